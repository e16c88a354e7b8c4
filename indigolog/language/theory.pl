:- module(indigolog_theory,
          [ load_theory/1,            % +FileOrFiles
            unload_theory/0,
            current_theory/1,         % -Theory
            theory_module/2,          % +Theory, -Module
            theory_files/2,           % +Theory, -Files
            plain_actions/2,          % +Theory, -Trie
            renewed_theory/1,         % -Theory
            fluent_template/3,        % +Theory, +Term, -Kind
            called_procedure/2,       % +Theory, +Term
            declared_fluent/2,        % +Theory, ?Fluent
            sensed_template/2,        % +Theory, +Fluent
            uncertain_template/2,     % +Theory, +Fluent
            action_template/3,        % +Theory, +Term, -Kind
            generalised/2,            % +Term, -Template
            domain_list/3,            % +Theory, +Domain, -Values
            theory_predicate/1        % ?Indicator
          ]).
:- use_module(library(lists), [append/3, member/2]).
:- use_module(library(apply), [maplist/2, maplist/3]).
:- use_module(library(error), [existence_error/2, must_be/2]).
:- use_module(library(gensym), [gensym/2]).
:- use_module(compiled, [compile_axioms/1]).
:- use_module('../tools/messages', []).
:- use_module(published, []).
:- use_module('../online/terminal', []).

/** <module> Action theories

A theory is one or more plain Prolog files, loaded into a module of its own,
that declare fluents, actions, axioms and procedures.  This module loads them
and answers what the axioms say, remembering initial values and the declared
ground instances of a fluent, which do not change while a program runs.

A theory is a term th(Module, Instances, tries(Initial, Plain), Values): the module
that holds the files, a module that holds the ground fluent instances (so that every
argument is indexed), the tries that remember initial values and plain actions, and
`possible` if some fluent may have several possible values, else `certain`.
*/

:- dynamic loaded/2.                  % Theory, Files: at most one fact

%!  theory_predicate(?Indicator) is nondet.
%
%   The predicates a theory may define.

theory_predicate(prim_fluent/1).
theory_predicate(fun_fluent/1).
theory_predicate(rel_fluent/1).
theory_predicate(prim_action/1).
theory_predicate(exog_action/1).
theory_predicate(poss/2).
theory_predicate(causes_val/4).
theory_predicate(causes_true/3).
theory_predicate(causes_false/3).
theory_predicate(senses/2).
theory_predicate(senses/5).
theory_predicate(settles/5).
theory_predicate(rejects/5).
theory_predicate(sensing/2).
theory_predicate(initially/2).
theory_predicate(proc/2).
theory_predicate(cache/1).
theory_predicate(execute/2).
theory_predicate(exog_occurs/1).

%!  load_theory(+FileOrFiles) is det.
%
%   Load a file, or a list of files, as the current theory.  The theory that was
%   current before is unloaded.
%
%   @error existence_error(source_sink, File) if there is no such file
%   @error golog(load(Files, Count)) if the files have errors, which have then
%          been printed with file and line

load_theory(Spec) :-
    (   is_list(Spec)
    ->  Specs = Spec
    ;   Specs = [Spec]
    ),
    maplist(theory_file, Specs, Files),
    unload_theory,
    gensym(indigolog_theory_, Module),
    prepare_module(Module),
    statistics(errors, Errors0),
    maplist(load_file(Module), Files),
    statistics(errors, Errors),
    (   Errors > Errors0
    ->  Count is Errors - Errors0,
        unload_files(Module, Files),
        throw(error(golog(load(Files, Count)), _))
    ;   true
    ),
    atom_concat(Module, '_instances', Instances),
    trie_new(Trie),
    trie_new(Plain),
    index_fluents(Module),
    index_actions(Module),
    (   Module:'$uncertain'(_)
    ->  Values = possible
    ;   Values = certain
    ),
    Theory = th(Module, Instances, tries(Trie, Plain), Values),
    compile_axioms(Theory),
    assertz(loaded(Theory, Files)).

theory_file(Spec, File) :-
    must_be(ground, Spec),
    (   absolute_file_name(Spec, File,
                           [ extensions(['', pl]), access(read),
                             file_errors(fail) ]),
        \+ exists_directory(File)
    ->  true
    ;   existence_error(source_sink, Spec)
    ).

prepare_module(Module) :-
    forall(theory_predicate(PI),
           ( dynamic(Module:PI),
             multifile(Module:PI),
             discontiguous(Module:PI) )),
    dynamic([ Module:'$fluent'/2, Module:'$action'/2, Module:'$sensed'/1,
              Module:'$uncertain'/1,
                           Module:'$instances'/2 ]),
    add_import_module(Module, indigolog_published, start),
    forall(older_axiom(Old, New),
           assertz(Module:term_expansion(Old, New))),
    Module:import(indigolog_terminal:ask_execute/2),
    Module:import(indigolog_terminal:ask_exog_occurs/1).

% Theories for the published evaluator of possible values (2005) write causes/4, and
% senses/1 beside settles/5 and rejects/5, which say the same.
older_axiom(causes(A, F, V, P), causes_val(A, F, V, P)).
older_axiom((causes(A, F, V, P) :- Body), (causes_val(A, F, V, P) :- Body)).
older_axiom(senses(_), []).

% SWI-Prolog loads a file without a header into one module only, so the file is
% included into a source of its own, which lies in the same directory.
load_file(Module, File) :-
    refuse_header(File),
    own_source(Module, File, Source),
    format(string(Text), ':- include(~q).~n', [File]),
    setup_call_cleanup(
        ( '$style_check'(Style, Style),
          style_check(-discontiguous),
          open_string(Text, Stream) ),
        load_files(Module:Source, [stream(Stream), silent(true)]),
        ( '$style_check'(_, Style),
          close(Stream) )).

own_source(Module, File, Source) :-
    file_directory_name(File, Directory),
    file_base_name(File, Base),
    format(atom(Source), '~w/~w as ~w', [Directory, Base, Module]).

refuse_header(File) :-
    setup_call_cleanup(
        open(File, read, In),
        catch(read(In, First), _, First = none),
        close(In)),
    (   nonvar(First),
        First = (:- module(Own, _))
    ->  throw(error(golog(module_header(File, Own)), _))
    ;   true
    ).

%!  unload_theory is det.
%
%   Forget the current theory, if there is one.

unload_theory :-
    (   retract(loaded(th(Module, _, _, _), Files))
    ->  unload_files(Module, Files)
    ;   true
    ).

unload_files(Module, Files) :-
    forall(member(File, Files),
           ( own_source(Module, File, Source),
             unload_file(Source) )).

%!  current_theory(-Theory) is det.
%
%   @error golog(no_theory) if none is loaded

current_theory(Theory) :-
    (   loaded(Theory0, _)
    ->  Theory = Theory0
    ;   throw(error(golog(no_theory), _))
    ).

theory_module(th(Module, _, _, _), Module).

theory_files(Theory, Files) :-
    loaded(Theory, Files).

%!  renewed_theory(-Theory) is det.
%
%   The current theory, without what was remembered of its initial values and declared
%   instances: helper facts may have changed since.  New tries, since SWI-Prolog 9.0.4
%   may crash when it lists one that was emptied.
%
%   @error golog(no_theory) if none is loaded

renewed_theory(Theory) :-
    current_theory(Old),
    Old = th(Module, Home, _, Values),
    forall(retract(Module:'$instances'(_, Instances)),
           ( Instances = ground(Instance, _) -> retractall(Instance) ; true )),
    trie_new(Initial),
    trie_new(Plain),
    Theory = th(Module, Home, tries(Initial, Plain), Values),
    retract(loaded(Old, Files)),
    assertz(loaded(Theory, Files)).

%!  plain_actions(+Theory, -Trie) is semidet.
%
%   Trie remembers the plain actions (compiled.pl) of a theory that has such.

plain_actions(th(_, _, tries(_, Plain), certain), Plain).


                /* What is declared */

% '$fluent'(Template, Kind): Kind is rel or fun; Template has fresh arguments.

index_fluents(Module) :-
    forall(( declaration(Module, Kind, Template),
             \+ Module:'$fluent'(Template, _) ),
           assertz(Module:'$fluent'(Template, Kind))),
    forall(( sensing_axiom(Module, Template),
             \+ Module:'$sensed'(Template) ),
           assertz(Module:'$sensed'(Template))),
    forall(( possible_values_axiom(Module, Template),
             \+ Module:'$uncertain'(Template) ),
           assertz(Module:'$uncertain'(Template))).

declaration(Module, Kind, Template) :-
    (   Kind = rel, Head = rel_fluent(F)
    ;   Kind = fun, Head = fun_fluent(F)
    ;   Kind = fun, Head = prim_fluent(F)
    ),
    head_template(Module, Head, F, Template).

% Declarations whose argument is a variable in the clause are asked for their
% solutions; the others name their functor.
head_template(Module, Head, F, Template) :-
    copy_term(Head-F, Head0-F0),
    clause(Module:Head0, Body),
    (   nonvar(F0)
    ->  true
    ;   catch(Module:Body, _, fail), nonvar(F0)
    ),
    generalised(F0, Template).

%!  generalised(+Term, -Template) is semidet.
%
%   Template has the functor of the callable Term, and fresh arguments.

generalised(Term, Template) :-
    callable(Term),
    functor(Term, Name, Arity, Type),
    functor(Template, Name, Arity, Type).

sensing_axiom(Module, Template) :-
    (   clause(Module:senses(_, F), _)
    ;   clause(Module:senses(_, _, F, _, _), _)
    ;   clause(Module:settles(_, _, F, _, _), _)
    ;   clause(Module:rejects(_, _, F, _, _), _)
    ),
    callable(F),
    generalised(F, Template).

possible_values_axiom(Module, Template) :-
    (   clause(Module:settles(_, _, F, _, _), _)
    ;   clause(Module:rejects(_, _, F, _, _), _)
    ),
    callable(F),
    generalised(F, Template).

index_actions(Module) :-
    forall(( member(Kind-Head, [ prim-prim_action(A), exog-exog_action(A) ]),
             head_template(Module, Head, A, Template),
             \+ Module:'$action'(Template, Kind) ),
           assertz(Module:'$action'(Template, Kind))).

%!  fluent_template(+Theory, +Term, -Kind) is semidet.
%
%   Term has the functor of a declared fluent; Kind is `rel` or `fun`.

fluent_template(th(Module, _, _, _), Term, Kind) :-
    Module:'$fluent'(Term, Kind),
    !.

%!  sensed_template(+Theory, +Fluent) is semidet.
%
%   Some sensing axiom speaks of the functor of Fluent, so that having no value
%   means that it is not known yet.

sensed_template(th(Module, _, _, _), Fluent) :-
    Module:'$sensed'(Fluent),
    !.

%!  uncertain_template(+Theory, +Fluent) is semidet.
%
%   A settles/5 or rejects/5 axiom speaks of the functor of Fluent, so that all
%   its initial values are possible ones.

uncertain_template(th(Module, _, _, _), Fluent) :-
    Module:'$uncertain'(Fluent),
    !.

%!  action_template(+Theory, +Term, -Kind) is nondet.
%
%   Term has the functor of a declared action; Kind is `prim` or `exog`.

action_template(th(Module, _, _, _), Term, Kind) :-
    Module:'$action'(Term, Kind).

%!  called_procedure(+Theory, +Term) is semidet.
%
%   There is a procedure, or an abbreviation, with the name and arity of Term.

called_procedure(th(Module, _, _, _), Term) :-
    generalised(Term, G),
    clause(Module:proc(G, _), _),
    !.

%!  declared_fluent(+Theory, ?Fluent) is nondet.

declared_fluent(th(Module, _, _, _), Fluent) :-
    (   Module:rel_fluent(Fluent)
    ;   Module:fun_fluent(Fluent)
    ;   Module:prim_fluent(Fluent)
    ).

%!  domain_list(+Theory, +Domain, -Values) is det.
%
%   The elements of a domain: a list, or the name of a predicate of the theory
%   whose only argument is that list.

domain_list(Theory, Domain, Values) :-
    (   is_list(Domain)
    ->  Values = Domain
    ;   callable(Domain),
        theory_module(Theory, Module),
        domain_goal(Domain, Values0, Goal),
        catch(Module:Goal, error(existence_error(procedure, _), _), fail),
        is_list(Values0)
    ->  Values = Values0
    ;   throw(error(golog(no_domain(Domain)), _))
    ).

domain_goal(Domain, Values, Goal) :-
    Domain =.. Parts0,
    append(Parts0, [Values], Parts),
    Goal =.. Parts.

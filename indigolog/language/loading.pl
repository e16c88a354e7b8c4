:- module(indigolog_loading,
          [ load_theory/1,            % +FileOrFiles
            load_theory/2,            % +FileOrFiles, -Theory
            unload_theory/1           % +Theory
          ]).
/** <module> Loading theories */

:- use_module(library(apply), [maplist/2, maplist/3]).
:- use_module(library(error), [existence_error/2, must_be/2]).
:- use_module(library(gensym), [gensym/2]).
:- use_module(library(lists), [member/2]).
:- use_module(library(memfile), [free_memory_file/1, new_memory_file/1, open_memory_file/4]).
:- use_module(compiled, [compile_axioms/1]).
:- use_module(directives, [missing/3]).
:- use_module(published, []).
:- use_module(theory).

:- dynamic
    files/2,                          % Module, Files: of each theory that is loaded
    unwanted/1.                       % Module: to be unloaded when no run uses it

% Other predicates that theories find there: Module:Name/Arity.
:- multifile theories_may_call/1.

%!  load_theory(+FileOrFiles) is det.
%
%   Load a file, or a list of files, as the current theory of this thread, and of all that
%   load none themselves if this is the main thread.  The theory that this thread had loaded
%   before is unloaded.
%
%   @error existence_error(source_sink, File) if there is no such file
%   @error golog(load(Files, Count)) if the files have errors, the first of which have
%          then been printed with file and line

load_theory(Spec) :-
    theory_files(Spec, Files),
    ( forget_current(Before) -> unload_module(Before) ; unload_at_end ),
    with_mutex(indigolog_loading, loaded(Files, Theory)),
    make_current(Theory).

%!  load_theory(+FileOrFiles, -Theory) is det.
%
%   Load a theory beside the others, for in_theory/2 and the option theory(Theory) of
%   indigolog/2, in whatever thread.  Errors are those of load_theory/1.

load_theory(Spec, Theory) :-
    theory_files(Spec, Files),
    with_mutex(indigolog_loading, loaded(Files, Theory)).

theory_files(Spec, Files) :-
    (   is_list(Spec)
    ->  Specs = Spec
    ;   Specs = [Spec]
    ),
    maplist(theory_file, Specs, Files).

loaded(Files, Theory) :-
    gensym(indigolog_theory_, Module),
    prepare_module(Module),
    counting_errors(maplist(load_file(Module), Files), Count),
    (   Count > 0
    ->  unload_sources(Module, Files),
        throw(error(golog(load(Files, Count)), _))
    ;   true
    ),
    index_fluents(Module),
    index_actions(Module),
    ( Module:'$uncertain'(_) -> Certainty = possible ; Certainty = certain ),
    new_theory(Module, Certainty, Theory),
    compile_axioms(Theory),
    assertz(files(Module, Files)).

% A file that is no theory at all has as many errors as lines: the first ones tell.
most_told(3).                         % chosen by hand

counting_errors(Goal, Count) :-
    nb_setval(indigolog_loading_errors, 0),
    setup_call_cleanup(
        asserta((user:thread_message_hook(_, error, _) :- indigolog_loading:one_error_more), Hook),
        Goal,
        erase(Hook)),
    nb_getval(indigolog_loading_errors, Count).

:- public one_error_more/0.

% True where it is not to be told.
one_error_more :-
    nb_getval(indigolog_loading_errors, Before),
    Count is Before + 1,
    nb_setval(indigolog_loading_errors, Count),
    most_told(Most),
    Count > Most.

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
              Module:'$uncertain'/1 ]),
    add_import_module(Module, indigolog_published, start),
    forall(member(Halt, [halt, halt(_)]),
           ( redefine_system_predicate(Module:Halt),
             assertz((Module:Halt :- indigolog_loading:no_halt)) )),
    forall(older_axiom(Old, New),
           assertz(Module:term_expansion(Old, New))),
    assertz((Module:term_expansion((:- Goal), []) :- indigolog_loading:refused(Goal, Module))),
    forall(theories_may_call(PI), indigolog_published:import(PI)).

:- public refused/2.

refused(Goal, Module) :-
    missing(Goal, Module, Missing),
    print_message(error, golog(directive(Missing))).

% Prolog would end, without a word, in the middle of a run.
:- public no_halt/0.

no_halt :-
    throw(error(golog(called_halt), _)).

% Theories for the published evaluator of possible values (2005) write causes/4, and
% senses/1 beside settles/5 and rejects/5, which say the same.
older_axiom(causes(A, F, V, P), causes_val(A, F, V, P)).
older_axiom((causes(A, F, V, P) :- Body), (causes_val(A, F, V, P) :- Body)).
older_axiom(senses(_), []).
older_axiom((senses(_) :- _), []).

% SWI-Prolog loads a file without a header into one module only, so the file is
% included into a source of its own, which lies in the same directory.  A file that is
% included is read in the encoding of the stream that includes it, and open_string/2
% knows no other than ISO Latin 1.
load_file(Module, File) :-
    refuse_header(File),
    own_source(Module, File, Source),
    setup_call_cleanup(
        ( '$style_check'(Style, Style),
          style_check(-discontiguous),
          new_memory_file(Includer),
          write_include(Includer, File),
          open_memory_file(Includer, read, Stream, [encoding(utf8)]) ),
        load_files(Module:Source, [stream(Stream), silent(true)]),
        ( '$style_check'(_, Style),
          close(Stream),
          free_memory_file(Includer) )).

write_include(Includer, File) :-
    setup_call_cleanup(
        open_memory_file(Includer, write, Stream, [encoding(utf8)]),
        format(Stream, ':- include(~q).~n', [File]),
        close(Stream)).

own_source(Module, File, Source) :-
    file_directory_name(File, Directory),
    file_base_name(File, Base),
    format(atom(Source), '~w/~w as ~w', [Directory, Base, Module]).

refuse_header(File) :-
    setup_call_cleanup(
        open(File, read, In, [encoding(utf8)]),
        catch(read(In, First), _, First = none),
        close(In)),
    (   nonvar(First),
        First = (:- module(Own, _))
    ->  throw(error(golog(module_header(File, Own)), _))
    ;   true
    ).

%!  unload_theory(+Theory) is det.
%
%   Forget Theory; where a run uses it, after that.

unload_theory(Theory) :-
    theory_module(Theory, Module),
    unload_module(Module).

unload_module(Module) :-
    assertz(unwanted(Module)),
    forall(( unwanted(Unwanted), \+ theory_used(Unwanted) ),
           ( retractall(unwanted(Unwanted)),
             forall(retract(files(Unwanted, Files)), unload_sources(Unwanted, Files)) )).

% The theory of a thread ends with it.
unload_at_end :-
    thread_self(Me),
    (   Me \== main
    ->  thread_at_exit(ignore(( forget_current(Module), unload_module(Module) )))
    ;   true
    ).

unload_sources(Module, Files) :-
    forall(member(File, Files),
           ( own_source(Module, File, Source),
             unload_file(Source) )).


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

:- module(indigolog_effort,
          [ found_within/5            % +Inferences, ?Template, :Goal, -Found, -Whole
          ]).
/** <module> Looking for something with a limit on what it may cost */

:- use_module(library(lists), [reverse/2]).
:- use_module('../language/theory', [current_theory/1, in_theory/2]).

:- meta_predicate found_within(+, ?, 0, -, -).

%!  found_within(+Inferences, ?Template, :Goal, -Found, -Whole) is det.
%
%   Found are the instances of Template for the solutions of Goal that are found within so many
%   Inferences; Whole is `true` if these are all.  In an engine of its own: in SWI-Prolog 9.0.4 a
%   limit that breaks off a findall/3 mixes its solutions with those of the findall/3 around it.

found_within(Inferences, Template, Goal, Found, Whole) :-
    current_theory(Theory),
    setup_call_cleanup(
        engine_create(Result, in_theory(Theory, limited(Inferences, Template, Goal, Result)), Engine),
        engine_next(Engine, found(Reversed, Whole)),
        engine_destroy(Engine)),
    reverse(Reversed, Found).

limited(Inferences, Template, Goal, Result) :-
    Result0 = found([], false),
    call_with_inference_limit(forall(Goal, add(Template, Result0)), Inferences, End),
    ( End == inference_limit_exceeded -> true ; nb_setarg(2, Result0, true) ),
    Result = Result0.

add(Template, Result) :-
    arg(1, Result, Found),
    nb_setarg(1, Result, [Template|Found]).

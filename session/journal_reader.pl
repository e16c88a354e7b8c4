:- module(session_journal_reader, []).
/** <module> What the journal of a session tells, running or ended

    swipl session/journal_reader.pl RUN_FOLDER newest|every

Each line on standard input asks once, and is answered by one JSON object on a line: the result so far, the program
that is left, and the actions that no answer has told yet (from the one numbered `first`), with the reasons of every
decision, or, since they take most of the time, of the newest of each kind.  The journal is followed by the session's
own program, without devices, so that what is told is what the controller knows; each action of it is met once, however
often is asked.  A controller from the folder itself is not run.
*/

:- set_prolog_flag(autoload, explicit). % as main.pl does
:- use_module(display/display, []).             % words for what is wrong
:- use_module(display/ending_words, [error_line/2]).
:- use_module(options/plan, [session_plan/2]).
:- use_module(display/reasons).
:- use_module(folder/result, [session_result/3]).
:- use_module(folder/resumption, [begun_options/2]).
:- use_module(folder/run_folder, [run_file/3]).
:- use_module('../indigolog/indigolog').
:- use_module(library(apply), [foldl/4]).
:- use_module(library(http/json), [json_write_dict/3]).
:- use_module(library(lists), [memberchk/2]).
:- use_module(library(pprint), [print_term/2]).
:- use_module(library(readutil), [read_line_to_string/2]).
:- set_prolog_flag(autoload, true).     % strategies may be written for it

:- initialization(tell, main).

:- dynamic
    loaded/2.                           % Options, Plan

tell :-
    current_prolog_flag(argv, [Folder, Reasons]),
    catch(begun(Folder, _, _), _, true),        % while nobody asks yet; what is wrong is found again then
    ( asked -> told(Folder, Reasons) ; true ).

%   After a problem from the beginning: it may have been one of that moment.
told(Folder, Reasons) :-
    catch(follow(Folder, Reasons), Error, true),
    (   nonvar(Error),
        problem(Error, Problem),
        answer(_{problem:Problem}),
        asked
    ->  told(Folder, Reasons)
    ;   true
    ).

follow(Folder, Reasons) :-
    begun(Folder, Options, Plan),
    run_file(Folder, 'history.pl', Journal),
    b_setval(journal_reader_actions, []),
    b_setval(journal_reader_first, 0),
    indigolog(Plan.program,
              [ check(false), replay(Journal), on_action(session_journal_reader:note),
                follow(session_journal_reader:answered(Reasons, Options, Plan)), outcome(_) ]).

%   What the session was begun with; its theory is loaded then.
begun(_, Options, Plan) :-
    loaded(Options, Plan),
    !.
begun(Folder, Options, Plan) :-
    begun_options(Folder, Options),
    session_plan(Options, Plan),
    load_theory(Plan.theory),
    assertz(loaded(Options, Plan)).

%   Somebody wants to know; fails where nobody will ask any more.
asked :-
    read_line_to_string(user_input, Line),
    Line \== end_of_file.

answer(Told) :-
    json_write_dict(user_output, Told, [width(0)]),
    nl,
    flush_output.

problem(error(golog(journal_differs(Entry, _)), _), Problem) :-
    !,
    format(string(Problem), "The controller of this version does not do what the journal tells next, ~q: \c
           the session was run by another version, and cannot be followed or resumed with this one", [Entry]).
problem(Error, Problem) :-
    error_line(Error, Problem).

:- public answered/5, note/2.

%   The journal has been followed: that is told, and the next question waited for.
answered(Reasons, Options, Plan, Rest, Situation) :-
    Session = session{options:Options, plan:Plan, status:running, seconds:[], errors:errors(null, [], []), command:""},
    session_result(Session, Situation, Result),
    left(Rest, Left),
    b_getval(journal_reader_actions, Newest),
    b_getval(journal_reader_first, First),
    foldl(action_dict(Reasons), Newest, []-[], _-Actions),
    statistics(cputime, Spent),
    answer(_{result:Result, first:First, actions:Actions, left:Left, controller_file:Plan.controller_file,
             spent_s:Spent}),
    length(Actions, Count),
    Next is First + Count,
    b_setval(journal_reader_first, Next),
    b_setval(journal_reader_actions, []),
    asked.

note(Action, Situation) :-
    b_getval(journal_reader_actions, Before),
    b_setval(journal_reader_actions, [Action-Situation|Before]).

%   The newest action comes first here, and Told are the names of those whose reasons are there.
action_dict(Reasons, Action-Situation, Told0-Dicts, Told-[Dict|Dicts]) :-
    functor(Action, Name, _),
    format(string(Text), "~q", [Action]),
    Plain = _{name:Name, text:Text},
    (   \+ ( Reasons == newest, memberchk(Name, Told0) ),
        decision_reason(Action, Situation, Reason)
    ->  fluent_value(device, Situation, Device),
        reason_dict(Device, Reason, ReasonDict),
        Dict = Plain.put(reason, ReasonDict),
        Told = [Name|Told0]
    ;   Dict = Plain,
        Told = Told0
    ).

%   The program that is left, as text; short, since only its beginning is where the session stands.
left(Rest, Text) :-
    with_output_to(string(Text), print_term(Rest, [output(current_output), right_margin(76)])).

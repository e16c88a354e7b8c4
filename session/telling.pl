:- module(session_telling, []).
:- use_module(display, []).             % words for what is wrong
:- use_module(plan, [session_plan/2]).
:- use_module(reasons).
:- use_module(result, [session_result/3]).
:- use_module(resumption, [begun_options/2]).
:- use_module(run_folder, [run_file/3]).
:- use_module('../indigolog/indigolog').
:- use_module(library(http/json), [json_write_dict/3]).
:- use_module(library(lists), [reverse/2]).
:- use_module(library(pprint), [print_term/2]).
:- use_module(library(readutil), [read_line_to_string/2]).

:- dynamic
    known/3.                            % Number, Action, Dict

/** <module> What the journal of a session tells, running or ended

    swipl session/telling.pl RUN_FOLDER

Each line on standard input asks once, and is answered by one JSON object on a line.  The journal is followed by
the session's own program, without devices, so that what is told is what the controller knows: the result so far,
the reason of each decision, and the program that is left.  A controller from the folder itself is not run.
*/

:- initialization(tell, main).

tell :-
    current_prolog_flag(argv, [Folder]),
    catch(( begun_options(Folder, Options),
            session_plan(Options, Plan),
            load_theory(Plan.theory),
            Ready = ready(Options, Plan) ),
          Error, Ready = failed(Error)),
    answers(Ready, Folder).

answers(Ready, Folder) :-
    read_line_to_string(user_input, Line),
    (   Line == end_of_file
    ->  true
    ;   catch(told(Ready, Folder, Told), Error, told(failed(Error), Folder, Told)),
        json_write_dict(user_output, Told, [width(0)]),
        nl,
        flush_output,
        answers(Ready, Folder)
    ).

told(failed(Error), _, _{problem:Problem}) :-
    '$messages':translate_message(Error, Lines, []),
    with_output_to(string(Text), print_message_lines(current_output, '', Lines)),
    split_string(Text, "\n", " \n", Lines1),
    atomic_list_concat(Lines1, ' ', Line),
    ( atom_concat('--resume: ', Problem, Line) -> true ; Problem = Line ).      % the folder is read as one that goes on
told(ready(Options, Plan), Folder, Told) :-
    run_file(Folder, 'history.pl', Journal),
    nb_setval(telling_actions, []),
    indigolog(Plan.program,
              [ check(false), replay(Journal), on_action(session_telling:note),
                situation(Situation), rest(Rest), outcome(_) ]),
    Session = session{options:Options, plan:Plan, status:running, seconds:[], errors:errors(null, [], []), command:""},
    session_result(Session, Situation, Result),
    left(Rest, Left),
    nb_getval(telling_actions, Newest),
    reverse(Newest, Actions),
    Told = _{result:Result, actions:Actions, left:Left, controller_file:Plan.controller_file}.

:- public note/2.

%   What is known already of an action that an earlier question met is not found anew.
note(Action, Situation) :-
    nb_getval(telling_actions, Before),
    length(Before, N),
    (   known(N, Action, Dict)
    ->  true
    ;   action_dict(Action, Situation, Dict),
        retractall(known(N, _, _)),
        assertz(known(N, Action, Dict))
    ),
    nb_setval(telling_actions, [Dict|Before]).

action_dict(Action, Situation, Dict) :-
    functor(Action, Name, _),
    format(string(Text), "~q", [Action]),
    Plain = _{name:Name, text:Text},
    (   decision_reason(Action, Situation, Reason)
    ->  fluent_value(device, Situation, Device),
        reason_dict(Device, Reason, ReasonDict),
        Dict = Plain.put(reason, ReasonDict)
    ;   Dict = Plain
    ).

%   The program that is left, as text; short, since only its beginning is where the session stands.
left(Rest, Text) :-
    with_output_to(string(Text), print_term(Rest, [output(current_output), right_margin(76)])).

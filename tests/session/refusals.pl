:- module(test_session_refusals, []).
/** <module> What is said of command lines that are no session's, many of them in one process

    swipl tests/session/refusals.pl     # a JSON list of them on standard input, each a list of words

Prints a JSON list of messages; an empty one for what a session would be begun with.
*/

:- use_module('../../session/options/options').
:- use_module('../../session/options/plan').
:- use_module('../../session/folder/run_folder').
:- use_module(library(apply), [maplist/3]).
:- use_module(library(http/json), [json_read/2, json_write_dict/2]).

:- initialization(tell, main).

tell :-
    json_read(user_input, Lines),
    maplist(said, Lines, Messages),
    json_write_dict(user_output, Messages).

said(Words, Message) :-
    catch(( session_options(Words, Options),
            session_plan(Options, Plan),
            check_run_folder(Options, Plan),
            Message = "" ),
          error(usage_error(Message), _), true).

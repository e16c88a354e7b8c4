:- module(session,
          [ run_session/2               % +Options, -ExitStatus
          ]).
:- use_module(acquisition_device,
              [close_acquisition/0, open_acquisition/1, score_pose/2, seconds_spent/1]).
:- use_module(display, []).
:- use_module(plan, [session_plan/2]).
:- use_module(processes, [check_alive/1, start_server/4, stop_server/1]).
:- use_module(result, [session_result/4, write_result/2]).
:- use_module(run_folder, [make_run_folder/2]).
:- use_module('../indigolog/indigolog', [indigolog/2, load_theory/1]).
:- use_module(library(lists), [member/2]).
:- use_module(library(option), [option/2, option/3]).

/** <module> One session from options to exit status

Servers that this session starts are stopped however it ends: normally, by an
error, by Ctrl-C or by SIGTERM.
*/

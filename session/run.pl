:- module(session_run,
          [ run_session/3               % +Options, +Opened, -ExitStatus
          ]).
:- use_module(acquisition_device).
:- use_module(display, []).
:- use_module(installation, [installation_python/1]).
:- use_module(processes, [wait_until/3]).
:- use_module(result).
:- use_module(resumption).
:- use_module(run_folder).
:- use_module(servers, [stop_servers/0]).
:- use_module('../domain/reasoning/candidates').
:- use_module('../domain/reasoning/image_set').
:- use_module('../domain/reasoning/merit').
:- use_module('../domain/reasoning/qualitative').
:- use_module('../indigolog/tools/checks').
:- use_module('../indigolog/indigolog').
:- use_module(library(http/json), [json_write_dict/3]).
:- use_module(library(apply), [foldl/4]).
:- use_module(library(lists), [member/2]).
:- use_module(library(option), [option/2]).
:- use_module(library(process), [process_create/3, process_kill/2, process_wait/3]).

/** <module> One session from options to exit status

Servers that this session starts are stopped however it ends: normally, by an
error, by Ctrl-C or by SIGTERM.

    0 pose found, 3 finished without reaching the threshold, 2 bad input,
    4 a device or server failed for good, 130 and 143 stopped by Ctrl-C and SIGTERM
*/

%!  run_session(+Options, +Opened, -ExitStatus) is det.
%
%   Opened is from open_session/2.

run_session(Options, Opened, Status) :-
    on_signal(int, _, stop_by),
    on_signal(term, _, stop_by),
    catch(session(Opened, Options, Status), Error, failed(Error, Status)).

:- public stop_by/1.

stop_by(Signal) :-
    throw(stopped(Signal)).

session(failed(Error), _, _) :-
    throw(Error).
session(dry_run(Plan), _, 0) :-
    check_controller(Plan),
    print_message(help, session(would_do(Plan))).
session(opened(Plan, Folder, Servers), Options, Status) :-
    call_cleanup(served_session(Options, Plan, Folder, Servers, Status), stop_everything).

served_session(Options, Plan, Folder, Servers, Status) :-
    catch(check_controller(Plan), Error, nothing_begun(Folder, Error)),
    ( option(resume(_), Options) -> true ; record_options(Options, Folder) ),
    show(Options, begin(Plan, Folder)),
    open_servers(Options, Plan, Folder, Servers),
    run_program(Options, Plan, Folder, Outcome),
    finish(Outcome, Options, Plan, Folder, Status).

check_controller(Plan) :-
    load_theory(Plan.theory),
    check_theory,
    check_program(Plan.program).

nothing_begun(Folder, Error) :-
    stop_everything,
    leave_run_folder(Folder),
    throw(Error).

                /*******************************
                *            SERVERS           *
                *******************************/

open_servers(Options, Plan, Folder, servers(ImageServer, VisionServer, Timeout)) :-
    start_arguments(Options, Plan, ImageServer, Folder, Args),
    open_acquisition([ image_server(ImageServer), vision_server(VisionServer),
                       alive(session_servers:check_servers), timeout(Timeout), start(Args) | Options ]).

%   Arguments of the vision server's `start`; what is not given it asks of the image server.
start_arguments(Options, Plan, ImageServer, Folder, Args) :-
    option(matcher(Matcher), Options),
    findall(Key-File,
            ( start_file(Key, Options, Plan, Given), absolute_file_name(Given, File) ),
            Files),
    dict_pairs(Args, start, [image_server-ImageServer, matcher-Matcher, seed-(Plan.seed), out-Folder|Files]).

start_file(camera_file, Options, _, File) :-
    option(camera_model(File), Options).
start_file(seed_pose_file, Options, _, File) :-
    option(seed_pose(File), Options).
start_file(model, Options, Plan, File) :-
    option(target(_), Options),
    member(Elsewhere, [stack(_), image_server(_)]),   % the others know the target they were started with
    option(Elsewhere, Options),
    File = Plan.model.

stop_everything :-
    catch(close_acquisition, error(_, _), true),
    stop_servers.

                /*******************************
                *          THE PROGRAM         *
                *******************************/

%   Outcome is finished, stopped(Signal) or failed(Error); the last situation is
%   kept whatever happens, so that nothing that was done is lost.
run_program(Options, Plan, Folder, Outcome) :-
    run_file(Folder, 'history.pl', Journal),
    (   option(resume(_), Options)
    ->  Resume = [resume(Journal)]
    ;   Resume = []
    ),
    nb_setval(session_situation, none),
    catch(( indigolog(Plan.program,
                      [ check(false), device(session_acquisition_device), journal(Journal), seed(Plan.seed),
                        on_action(session_run:after_action(Options)) | Resume ]),
            Outcome = finished ),
          Error,
          ended_by(Error, Outcome)).

ended_by(stopped(Signal), Outcome) =>
    Outcome = stopped(Signal).
ended_by(Error, Outcome) =>
    Outcome = failed(Error).

:- public after_action/3.

%   Called by the executive after each action and each exogenous one.
after_action(Options, Action, Situation) :-
    nb_setval(session_situation, Situation),
    (   shown(Action, Situation, Message)
    ->  show(Options, Message)
    ;   true
    ),
    (   option(explain(true), Options),
        explained(Action, Situation, Message)
    ->  show(Options, Message)
    ;   true
    ).

shown(connect, Situation, connected(Device)) :-
    fluent_value(device, Situation, Device).
shown(keep(_), Situation, step(Device, Step)) :-
    last_step(Situation, Device, Step).
shown(discard(_, _), Situation, step(Device, Step)) :-
    last_step(Situation, Device, Step).
shown(advance(Range), _, hold(Range)).
shown(hold_done(Outcome), _, hold_done(Outcome)).
shown(Event, _, event(Event)) :-
    event(Event).

event(light_fault(_)).
event(camera_fault).
event(sun_changed).

%   What --explain adds: why these settings, what the image shows, what it changed.
explained(choose(Settings), Situation, chosen(Device, Settings, Why)) :-
    fluent_value(device, Situation, Device),
    fluent_value(readings, Situation, Readings),
    fluent_value(image_set, Situation, ImageSet),
    fluent_value(unfavourable, Situation, Unfavourable),
    kept_states(ImageSet, Kept),
    ranking(Device, experience(Readings, Kept, Unfavourable), Ranked),
    memberchk(ranked(_, Settings, Why), Ranked).
explained(capture(_, _), Situation, seen(Statistics, Quality)) :-
    fluent_value(statistics, Situation, Statistics),
    image_quality(Statistics, Quality).
explained(estimate(_), Situation, measured(Fix, New, Old)) :-
    fluent_value(fix, Situation, Fix),
    fluent_value(merit, Situation, Old),
    merit(Fix, New).

last_step(Situation, Device, Step) :-
    fluent_value(device, Situation, Device),
    fluent_value(steps, Situation, [Step|_]).

                /*******************************
                *            THE END           *
                *******************************/

finish(Outcome, Options, Plan, Folder, Status) :-
    nb_getval(session_situation, Situation),
    (   Situation == none
    ->  true                            % nothing happened: there is nothing to tell
    ;   seconds(Seconds),
        outcome_status(Outcome, Situation, Name),
        true_error(Situation, Error),
        threshold(Situation, Threshold),
        command_line(Command),
        session_result(_{ status:Name, controller:(Plan.controller), target:(Plan.target),
                          seed:(Plan.seed), command:Command, seconds:Seconds, error:Error,
                          threshold_px:Threshold },
                       session_run:value_in(Situation), Result),
        run_file(Folder, 'result.json', File),
        write_result(Result, File),
        stop_everything,                % the vision server flushes its images
        show(Options, outcome(Name, Result)),
        ( option(json(true), Options) -> print_result(Result) ; true ),
        report(Options, Plan, Folder)   % last: who waits for the pose need not wait for its picture
    ),
    exit_status(Outcome, Situation, Status).

value_in(Situation, Fluent, Value) :-
    fluent_value(Fluent, Situation, Value).

outcome_status(finished, Situation, Status) =>
    ( trusted(Situation) -> Status = converged ; Status = exhausted ).
outcome_status(_, _, Status) =>
    Status = stopped.

exit_status(finished, Situation, Status) =>
    ( trusted(Situation) -> Status = 0 ; Status = 3 ).
exit_status(stopped(int), _, Status) =>
    Status = 130.
exit_status(stopped(_), _, Status) =>
    Status = 143.
exit_status(failed(Error), _, Status) =>
    failed(Error, Status).

% A session without hold points trusts its pose; an approach needs its last one fixed.
trusted(Situation) :-
    fluent_value(holds, Situation, [hold(_, Outcome, _)|_]),
    !,
    Outcome == reached.
trusted(Situation) :-
    situation_holds(converged, Situation).

true_error(Situation, Error) :-
    fluent_value(best, Situation, fix(Pose, _, _, _)),
    catch(score_pose(Pose, Error), error(_, _), fail),
    !.
true_error(_, null).

threshold(Situation, Threshold) :-
    fluent_value(threshold, Situation, Value),
    ( number(Value) -> Threshold = Value ; Threshold = null ).

command_line(Command) :-
    current_prolog_flag(argv, Arguments),
    atomic_list_concat(['swipl main.pl'|Arguments], ' ', Command).

%   In all since the process began.  What the servers did not use of the time they
%   were waited for is the bridge's.
seconds([total-Total, controller-Controller, bridge-Bridge|Parts]) :-
    statistics(epoch, Start),
    get_time(Now),
    Total is Now - Start,
    seconds_spent(Waiting, Parts),
    foldl(add_part, Parts, 0.0, Served),
    Controller is max(0.0, Total - Waiting),
    Bridge is max(0.0, Waiting - Served).

add_part(_-Seconds, Sum0, Sum) :-
    Sum is Sum0 + Seconds.

report(Options, Plan, Folder) :-
    option(report(true), Options),
    !,
    installation_python(Python),
    catch(( process_create(Python, ['-m', report, Folder],
                           [ process(Pid), cwd(Plan.root), stdout(null) ]),
            get_time(Now),
            Deadline is Now+60,
            wait_until(Deadline, Pid, Status),
            ( Status == timeout -> process_kill(Pid, kill), process_wait(Pid, _, []) ; true ) ),
          error(_, _), Status = failed),
    (   Status == exit(0)
    ->  run_file(Folder, 'report.html', File),
        show(Options, report(File))
    ;   print_message(warning, session(no_report(Status)))
    ).
report(_, _, _).

print_result(Result) :-
    json_write_dict(user_output, Result, [width(110)]),
    nl(user_output).

%   Live lines go to standard error, which leaves standard output to --json.
show(Options, _) :-
    option(quiet(true), Options),
    !.
show(_, Message) :-
    print_message(help, session(Message)).

                /*******************************
                *            FAILURE           *
                *******************************/

%   What went wrong, in one message, and the exit status that goes with it.
failed(stopped(Signal), Status) :-
    !,
    exit_status(stopped(Signal), none, Status).
failed(error(golog(reported), _), 2) :-
    !.                                  % its problems have been printed
failed(Error, Status) :-
    error_status(Error, Status),
    plain(Error, Plain),
    print_message(error, Plain).

% Where in the program it was tells something about a program's error, not a server's.
plain(error(Formal, _), Plain), Formal \= golog(_) =>
    Plain = error(Formal, _).
plain(Error, Plain) =>
    Plain = Error.

error_status(error(usage_error(_), _), 2) :- !.
error_status(error(golog(_), _), 2) :- !.
error_status(error(existence_error(source_sink, _), _), 2) :- !.
error_status(error(server_died(_, exit(2), _, _), _), 2) :- !.
error_status(error(server_error(bad_input, _, _), _), 2) :- !.
error_status(_, 4).

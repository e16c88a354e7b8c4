:- module(session_run,
          [ run_session/3               % +Options, +Opened, -ExitStatus
          ]).
/** <module> One session: options, plan, run, result

Servers that this session starts are stopped however it ends: normally, by an
error, by Ctrl-C or by SIGTERM.
*/

:- use_module(device/acquisition_device, [close_acquisition/0, execute/2, open_acquisition/1]).
:- use_module(servers/connections, [ask/4]).
:- use_module(servers/described, [check_as_begun/4, described_model/2, draws/4, kept_description/2]).
:- use_module(display/display, [show/2, show_address/0, tell/3]).
:- use_module(ending, [end_session/3, exit_status/2]).
:- use_module(holding, [forget_hold/1, wait_while_held/1]).
:- use_module(opening, [end_if_stopped/0]).
:- use_module(options/plan, [within_reach/4]).
:- use_module(display/reporting, [begin_report/2, drop_report/0]).
:- use_module(folder/resumption, [record_options/2]).
:- use_module(folder/result, [keep_output_for_result/0]).
:- use_module(folder/run_folder, [leave_run_folder/3, run_file/3]).
:- use_module(servers/servers, [image_server_past/1, own_server/1, served_before/1, stop_servers/0]).
:- use_module(display/live_table, [begin_table/2, end_table/0]).
:- use_module(display/viewing, [start_view/2]).
:- use_module(strategy/thinking, [apart_from_thought/1, note_thought/0, tell_thought/1, within_budget/4]).
:- use_module(times, [forget_times/1, tell_times/3]).
:- use_module(strategy/strategy_end, [ended_by/4]).
:- use_module(strategy/named_actions, [check_chosen/1]).
:- use_module(strategy/own_sensing, [check_own_sensing/1]).
:- use_module(strategy/strategy_checks, [check_control/1, check_includes/1]).
:- use_module(shell_words, [shell_word/2]).
:- use_module(usage_errors, [usage_error/2]).
:- use_module('../indigolog/tools/checks').
:- use_module('../indigolog/indigolog').
:- autoload(library(filesex), [delete_directory_and_contents/1]).
:- use_module(library(lists), [append/3, member/2]).
:- use_module(library(option), [option/2]).

%!  run_session(+Options, +Opened, -ExitStatus) is det.
%
%   Opened is from open_session/2; the exit status as of ending.pl.

run_session(Options, Opened, Status) :-
    ( option(json(true), Options) -> keep_output_for_result ; true ),
    on_signal(int, _, stop_by),
    on_signal(term, _, stop_by),
    catch(session(Opened, Options, Outcome), Error, Outcome = failed(Error)),
    exit_status(Outcome, Status).

:- public stop_by/1.

stop_by(Signal) :-
    tell_thought(stopped),
    throw(stopped(Signal)).

session(failed(Error), _, failed(Error)).
session(opened(Plan, Folder, Servers), Options, Outcome) :-
    Session = session{options:Options, plan:Plan, folder:Folder, servers:Servers},
    (   option(dry_run(true), Options)
    ->  call_cleanup(checked_session(Session), ( stop_everything, delete_directory_and_contents(Folder) )),
        Outcome = checked
    ;   call_cleanup(served_session(Session, Outcome), ( stop_everything, drop_report ))
    ).

%   All but what touches the world: the servers take what they are told, and know what the strategy names.
checked_session(Session) :-
    end_if_stopped,
    check_controller(Session.plan),
    open_servers(Session),
    execute(connect, session(Device, _, _)),
    with_description(Session, Named),
    show([], would_do(Named.plan, Device)).

served_session(Session, Outcome) :-
    _{options:Options, plan:Plan, folder:Folder} :< Session,
    catch(( end_if_stopped, check_controller(Plan) ), Error0, nothing_begun(Options, Folder, Error0)),
    show(Options, begin(Plan, Folder)),
    forget_hold(Folder),
    start_view(Options, Folder),
    begin_table(Options, Plan),
    catch(( open_servers(Session), with_description(Session, Named), record(Named) ),
          Error1, nothing_begun(Options, Folder, Error1)),
    begin_report(Options, Folder),
    catch(( run_program(Named, End, Situation),
            end_session(Named.put(stop, session_run:stop_everything), end(End, Situation), Outcome) ),
          error(Formal, _), cannot_go_on(Formal, Folder)),
    ( Situation == none -> stop_everything, why(End, Why), leave_run_folder(Options, Folder, Why) ; true ).

why(failed(Error), Why) => Why = Error.
why(_, Why)             => Why = none.

record(Session) :-
    _{options:Options, folder:Folder, described:Description} :< Session,
    (   option(resume(_), Options)
    ->  true
    ;   kept_description(Description, Kept),
        catch(record_options(Options, Kept), error(io_error(write, _), _),
              usage_error("cannot write to the run folder ~w: is there space?", [Folder]))
    ).

%   What is wrong with the run folder is said of the folder.
cannot_go_on(_, Folder) :-
    \+ exists_directory(Folder),
    usage_error("the run folder ~w is not there any more", [Folder]).
cannot_go_on(io_error(write, _), Folder) :-
    shell_word(Folder, Word),
    usage_error("cannot write to the run folder: is there space? Then --resume ~w goes on", [Word]).
cannot_go_on(Formal, _) :-
    throw(error(Formal, _)).

check_controller(Plan) :-
    check_includes(Plan.controller_file),
    load_theory(Plan.theory),
    check_control(Plan.controller_file),
    check_own_sensing(Plan.controller_file),
    check_chosen(Plan.controller_file),
    check_theory,
    check_program(Plan.program).

nothing_begun(Options, Folder, Error) :-
    end_table,
    stop_everything,
    leave_run_folder(Options, Folder, Error),
    throw(Error).

stop_everything :-
    catch(close_acquisition, error(_, _), true),
    stop_servers.

                /*******************************
                *            SERVERS           *
                *******************************/

open_servers(Session) :-
    _{options:Options, servers:servers(ImageServer, VisionServer)} :< Session,
    start_arguments(Session, ImageServer, Args),
    findall(Name, own_server(Name), Own),
    open_acquisition([ image_server(ImageServer), vision_server(VisionServer), own(Own), start(Args),
                       controller_file(Session.plan.controller_file) | Options ]),
    (   served_before(image_server)
    ->  image_server_past(Past),
        ask(image_server, restart, Past, _)
    ;   true
    ).

%   What the image server tells of its device, which has to be that of a session that goes on, and of the target: its name,
%   where the command line does not name it, and how near it can come.
with_description(Session, Session.put(_{plan:Named, described:Description})) :-
    _{options:Options, plan:Plan0, folder:Folder} :< Session,
    ask(image_server, describe, _{}, Description),
    ( option(dry_run(true), Options) -> true ; check_as_begun(Options, Folder, Plan0.seed, Description) ),
    within_reach(Options, Description, Plan0, Plan),
    ( Plan.program == Plan0.program -> true ; show(Options, farther(Plan.program)) ),
    (   Plan.shows \= target(_),
        described_model(Description, Model)
    ->  file_base_name(Model, Base),
        file_name_extension(Name, _, Base),
        Named = Plan.put(target, Name)
    ;   Named = Plan
    ).

%   Arguments of the vision server's `start`; what is not given it asks of the image server.
start_arguments(Session, ImageServer, Args) :-
    _{options:Options, plan:Plan, folder:Folder} :< Session,
    option(matcher(Matcher), Options),
    findall(Key-File,
            ( start_file(Key, Options, Plan, Name), absolute_file_name(Name, File) ),
            Files),
    findall(unit-Unit, ( member(model-_, Files), option(unit(Unit), Options) ), Units),
    append(Files, Units, Given),
    ( option(dry_run(true), Options) -> All = Given ; All = [out-Folder|Given] ),
    ( option(first_sight(true), Options) -> Told = [first_sight-true|All] ; Told = All ),
    dict_pairs(Args, start, [image_server-ImageServer, matcher-Matcher, seed-(Plan.seed)|Told]).

start_file(camera_file, Options, _, File) :-
    option(camera_model(File), Options).
start_file(seed_pose_file, Options, _, File) :-
    option(seed_pose(File), Options).
start_file(model, Options, Plan, File) :-
    option(target(_), Options),
    member(Elsewhere, [stack(_), image_server(_)]),   % the others know the target they were started with
    option(Elsewhere, Options),
    File = Plan.model.

                /*******************************
                *          THE PROGRAM         *
                *******************************/

%   End is finished, stopped(Signal) or failed(Error); Situation is the last one, whatever happens, so that nothing
%   that was done is lost, or `none`.
run_program(Session, End, Situation) :-
    _{options:Options, plan:Plan, folder:Folder} :< Session,
    run_file(Folder, 'history.pl', Journal),
    nb_setval(session_situation, none),
    catch(( beginning(Session, Journal, Beginning),
            most_thinking_s(Most),
            within_budget(Options, Plan.controller_file, Most,
                          indigolog(Plan.program,
                                    [ check(false), device(session_acquisition_device), journal(Journal), Beginning,
                                      on_action(session_run:after_action(Options, Folder)) ])),
            End = finished ),
          Error,
          ( nb_getval(session_situation, Last), ended_by(Error, Session, Last, End) )),
    end_table,
    forget_hold(Folder),
    forget_times(Folder),
    nb_getval(session_situation, Situation).

most_thinking_s(60).                    % of a strategy, between two actions; chosen by hand: those here need less than one

%   A session that goes on finds the seed of its draws in its journal.  What a strategy draws depends on the seed and on the
%   scene as it is known beforehand, so that one seed is not the same lucky or unlucky settings everywhere.
beginning(Session, Journal, resume(Journal)) :-
    option(resume(_), Session.options),
    !.
beginning(Session, _, seed(Draws)) :-
    Seed = Session.plan.seed,
    ( draws(Session.described, Seed, _, Draws0) -> Draws = Draws0 ; Draws = Seed ).

:- public after_action/4.

%   Called by the executive after each action and each exogenous one.
after_action(Options, Folder, Action, Situation) :-
    nb_setval(session_situation, Situation),
    note_thought,
    show_address,
    tell(Options, Action, Situation),
    tell_times(Options, Folder, Action),
    apart_from_thought(wait_while_held(Folder)),
    check_images_come(Options, Action).

%   A strategy that goes on for ever without an image meets no limit on images.
most_actions_without_image(1000).       % chosen by hand: an image needs some five

check_images_come(_, capture(_, _)) =>
    nb_setval(session_idle_actions, 0).
check_images_come(Options, _) =>
    ( nb_current(session_idle_actions, Before) -> true ; Before = 0 ),
    Idle is Before + 1,
    nb_setval(session_idle_actions, Idle),
    most_actions_without_image(Most),
    (   Idle > Most
    ->  option(controller(Controller), Options),
        usage_error("~w: the strategy did ~d actions and took no image meanwhile; does one of its loops never end?",
                    [Controller, Most])
    ;   true
    ).

:- module(session_ending,
          [ end_session/3,              % +Session, +End, -Outcome
            exit_status/2               % +Outcome, -ExitStatus
          ]).
/** <module> How a session ends: result.json, report.html, and the exit status

    0 pose found, 3 finished without reaching the threshold, 2 bad input,
    4 a device or server failed for good, 130 and 143 stopped by Ctrl-C and SIGTERM
*/

:- use_module(device/acquisition_device, [close_acquisition/0, score_pose/3]).
:- use_module(device/told_beside, [told_beside/3]).
:- use_module(servers/connections, [ask/4]).
:- use_module(servers/described, [recorded_frames/2]).
:- use_module(display/display, [show/2, show_outcome/2]).
:- use_module(display/ending_words, [plain_error/2, why_stopped/2]).
:- use_module(display/outcome, [advised/4]).
:- use_module(display/reporting, [tell_report/0, wait_for_report/2]).
:- use_module(folder/result).
:- use_module(folder/run_folder, [run_file/3]).
:- use_module(folder/session_file, [file_sha256/2]).
:- use_module(installation, [installed_command/0]).
:- use_module(shell_words, [shell_word/2]).
:- use_module(times, [session_seconds/1]).
:- use_module('../domain/reasoning/instead', [instead_image/2]).
:- use_module('../indigolog/indigolog').
:- use_module('../indigolog/tools/explain', [why/3]).
:- use_module(library(aggregate), [aggregate_all/3]).
:- use_module(library(apply), [foldl/4, maplist/3]).
:- use_module(library(lists), [member/2, nth0/3]).
:- use_module(library(option), [option/2]).
:- use_module(library(solution_sequences), [limit/2]).

%!  end_session(+Session, +End, -Outcome) is det.
%
%   Write and tell what came of a session.  End is end(How, Situation), with How one of
%   finished, stopped(Signal) and failed(Error), and Situation the last one, or `none`.
%   Session.stop is called when all is known, to stop the servers; the report is written meanwhile.
%   Outcome is converged, exhausted, stopped(Signal) or failed(Error).

end_session(_, end(How, none), Outcome) :-
    !,                                  % nothing happened: there is nothing to tell
    outcome(How, none, Outcome).
end_session(Session, end(How0, Situation), Outcome) :-
    _{options:Options, folder:Folder} :< Session,
    known_result(Session, How0, Situation, How, Result),
    sig_atomic(write_result(Result, Folder)),
    catch(close_acquisition, error(_, _), true),        % the vision server writes what is left of its images
    tell_report,
    call(Session.stop),
    show_outcome(Options, Result),
    tell_of_instead(Options, Result),
    tell_why_no_further(Options, Result, Situation),
    tell_how_to_go_on(Options, How, Folder),
    wait_for_report(Options, Folder),   % last: who waits for the pose need not wait for its picture
    outcome(How, Situation, Outcome).

%   What is known takes requests to the servers: a session that is stopped meanwhile was stopped, and tells what it has.
known_result(Session, How0, Situation, How, Result) :-
    catch(( result_of(Session, How0, Situation, Result), How = How0 ), stopped(Signal), How = stopped(Signal)),
    ( var(Result) -> result_of(Session, How, Situation, Result) ; true ).

result_of(Session, How, Situation, Result) :-
    _{options:Options, folder:Folder} :< Session,
    outcome(How, Situation, Outcome),
    outcome_status(Outcome, Status),
    session_seconds(Seconds),
    true_errors(Situation, Errors),
    command_line(Command),
    session_result(Session.put(_{status:Status, seconds:Seconds, errors:Errors, command:Command}),
                   Situation, Known),
    parameters(How, Parameters),
    option(max_iterations(Limit), Options),
    recorded_frames(Session.described, Recorded),
    fluent_value(readings, Situation, Readings),
    foldl(call, [ with_other_poses(Parameters, Situation), with_estimated_with(Parameters, Folder),
                  advised(images(Limit, Recorded), Readings), with_message(How) ],
          Known, Result).

with_message(How, Result0, Result) :-
    ( why_stopped(How, Why) -> Result = Result0.put(message, Why) ; Result = Result0 ).

%   What if: the image that was to be taken otherwise was not taken at all.
tell_of_instead(Options, Result) :-
    option(instead(Words), Options),
    instead_image(Words, Number),
    Result.iterations < Number,
    !,
    print_message(warning, session(ended_before(Number))).
tell_of_instead(_, _).

%   Interrupts end where none can go on, and a program may end before it has begun: that says nothing of what was in the way.
tell_why_no_further(Options, Result, Situation) :-
    Result.status == exhausted,
    ( Result.iterations =:= 0 -> true ; situation_history(Situation, [stop_interrupts|_]) ),
    \+ situation_holds(exhausted, Situation),
    catch(why(control, Situation, Whys), error(_, _), fail),
    Whys = [_|_],
    !,
    show(Options, no_further(Whys)).
tell_why_no_further(_, _, _).

%   A session that was interrupted can go on; one whose strategy went wrong would come to the same again.
tell_how_to_go_on(Options, How, Folder) :-
    interrupted(How, By),
    !,
    show(Options, goes_on(By, Folder)).
tell_how_to_go_on(_, _, _).

interrupted(stopped(int), ctrl_c).
interrupted(stopped(Signal), other) :-
    Signal \== int.
interrupted(failed(Error), failure) :-
    error_status(Error, Status),
    Status =:= 4.

outcome(finished, Situation, Outcome) =>
    ( trusted(Situation) -> Outcome = converged ; Outcome = exhausted ).
outcome(How, _, Outcome) =>
    Outcome = How.

outcome_status(converged, Status) => Status = converged.
outcome_status(exhausted, Status) => Status = exhausted.
outcome_status(_, Status)         => Status = stopped.

% A session without hold points trusts its pose; an approach needs its last one fixed.
trusted(Situation) :-
    fluent_value(holds, Situation, [hold(_, Outcome, _)|_]),
    !,
    Outcome == reached.
trusted(Situation) :-
    situation_holds(converged, Situation).

%   How far off the best pose is, those of the steps since the target moved last, newest first, and those of the hold
%   points, newest first; null where that is not known.
true_errors(Situation, errors(Best, Steps, Holds)) :-
    situation_history(Situation, History),
    aggregate_all(count, member(advance(_), History), Moves),
    ( Moves =:= 0 -> Last = here ; Last = after(Moves, Moves) ),
    fluent_value(best, Situation, Fix),
    true_error(Last, Fix, Best),
    (   Best == null
    ->  Steps = []
    ;   fluent_value(taken, Situation, Taken),
        fluent_value(candidate, Situation, Candidate),
        ( Candidate == none -> Told = Taken ; Told is Taken - 1 ),
        fluent_value(steps, Situation, All),
        findall(Error,
                ( limit(Told, member(step(_, _, _, _, _, _, _, Tried, _), All)), true_error(Last, Tried, Error) ),
                Steps)
    ),
    fluent_value(holds, Situation, Newest),
    length(Newest, Count),
    findall(Error,
            ( nth0(I, Newest, hold(_, _, Found)), N is Count - I, true_error(after(N, Moves), Found, Error) ),
            Holds).

true_error(Where, fix(Pose, _, _, _), Error) :-
    catch(score_pose(Pose, Where, Error), error(_, _), fail),
    !.
true_error(_, _, null).

%   Of the vision server, when the session came to its end; else `none`.
parameters(finished, Parameters) :-
    catch(ask(vision_server, parameters, _{}, Parameters), error(_, _), fail),
    !.
parameters(_, none).

%   Of a target that was looked for everywhere all poses that fit as the stated one does, and what no image can tell of any
%   pose, where there are such: from the estimate that stated it, of images that are still in the set.
with_other_poses(Parameters, Situation, Result0, Result) :-
    is_dict(Parameters),
    situation_history(Situation, Newest),
    fluent_value(best, Situation, Best),
    fluent_value(image_set, Situation, Set),
    findall(Image, member(kept(Image, _), Set), Kept),
    member(e(estimate(Images), Best), Newest),      % another one may have been of an image that was discarded
    subset(Images, Kept),
    told_beside(Images, Best, More),
    !,
    Result = Result0.put(More).
with_other_poses(_, _, Result, Result).

%   What the pose was estimated with, so that it can be estimated again: a session that came to its end tells it.
with_estimated_with(Parameters, Folder, Result0, Result) :-
    is_dict(Parameters),
    run_file(Folder, 'images/stack.toml', Stack),
    exists_file(Stack),                 % not where the vision server is on another machine
    !,
    file_sha256(Stack, Sha256),
    Result = Result0.put(estimated_with, _{parameters:Parameters, stack_sha256:Sha256}).
with_estimated_with(_, _, Result, Result).

command_line(Command) :-
    current_prolog_flag(argv, Arguments),
    ( installed_command -> Name = 'lights-and-camera' ; Name = 'swipl main.pl' ),
    maplist(shell_word, Arguments, Words),
    atomic_list_concat([Name|Words], ' ', Command).

                /*******************************
                *         EXIT STATUS          *
                *******************************/

%!  exit_status(+Outcome, -ExitStatus) is det.
%
%   What went wrong is said here, in one message.

exit_status(checked, Status)               => Status = 0.
exit_status(converged, Status)             => Status = 0.
exit_status(exhausted, Status)             => Status = 3.
exit_status(stopped(int), Status)          => Status = 130.
exit_status(stopped(_), Status)            => Status = 143.
exit_status(failed(stopped(Signal)), Status) =>
    exit_status(stopped(Signal), Status).
exit_status(failed(error(golog(reported), _)), Status) =>
    Status = 2.                         % its problems have been printed
exit_status(failed(Error), Status) =>
    error_status(Error, Status),
    plain_error(Error, Plain),
    print_message(error, Plain).

error_status(error(usage_error(_), _), 2) :- !.
error_status(error(io_error(_, _), _), 2) :- !.
error_status(error(golog(_), _), 2) :- !.
error_status(error(bridge_refused(_), _), 2) :- !.
error_status(error(existence_error(source_sink, _), _), 2) :- !.
error_status(error(server_died(_, exit(2), _, _), _), 2) :- !.
error_status(error(server_error(bad_input, _, _), _), 2) :- !.
error_status(_, 4).

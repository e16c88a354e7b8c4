:- module(session_result,
          [ session_result/3,           % +Session, +Situation, -Result
            write_result/2,             % +Result, +Folder
            print_result/1,             % +Result
            keep_output_for_result/0
          ]).
/** <module> result.json

The session's outcome as a dict, made from the fluents' values in its last situation.
docs/result.md says what its keys mean, bridge/result_file.py what they hold; its JSON
Schema is session/result.schema.json.  session/ending.pl adds what only the end knows:
poses, parameters, advice, a message.
*/

:- use_module('../json_terms').
:- use_module(run_folder, [replace_file/2, run_file/3]).
:- use_module('../../domain/reasoning/device').
:- use_module('../../domain/reasoning/merit').
:- use_module('../../domain/reasoning/qualitative').
:- use_module('../../indigolog/indigolog', [fluent_value/3, situation_history/2]).
:- use_module(library(apply), [maplist/3]).
:- use_module(library(http/json), [json_write_dict/3]).
:- use_module(library(lists), [list_to_set/2, member/2, memberchk/2, nth1/3, reverse/2]).
:- use_module(library(option), [option/2]).

:- dynamic
    kept_output/1.                      % Stream

format_version(1).

%   Units of the keys whose names do not tell.
units(_{rotation_vector:rad, translation:m, covariance:"rad^2, rad m and m^2", aperture:"f-number", seconds:s,
        uncertainty:"0.01 is 1 % of the range or 1 degree"}).

covariance_order([rotation_x, rotation_y, rotation_z, translation_x, translation_y, translation_z]).

%!  session_result(+Session, +Situation, -Result) is det.
%
%   Session is a dict of what the fluents do not know: options and plan; status, command, seconds (a list of
%   Part-Seconds), and errors(Best, Steps, Holds), how far off the best pose is and those of the last steps and of the
%   hold points, newest first: dicts, or null.

session_result(Session, Situation, Result) :-
    _{options:Options, plan:Plan, errors:errors(Error, StepErrors, HoldErrors)} :< Session,
    fluent_value(best, Situation, Best),
    fix_dict(Best, Fix),
    fluent_value(merit, Situation, Merit),
    fluent_value(iteration, Situation, Iterations),
    fluent_value(threshold, Situation, Threshold),
    fluent_value(device, Situation, Device),
    fluent_value(steps, Situation, Steps),
    situation_history(Situation, Newest),
    findall(Image-Asked, member(capture(Image, Asked), Newest), Wanted),
    step_dicts(Device, Wanted, Steps, StepErrors, StepDicts),
    images(keep, StepDicts, Kept),
    images(discard, StepDicts, Discarded),
    source(Options, Scenario, Stack),
    light_dicts(Device, Lights),
    dict_pairs(Seconds, seconds, Session.seconds),
    format_version(Version),
    units(Units),
    covariance_order(Order),
    Told = Fix.put(_{version:Version, units:Units, covariance_order:Order, status:Session.status,
                     controller:Plan.controller, target:Plan.target, scenario:Scenario, stack:Stack, lights:Lights,
                     seed:Plan.seed, command:Session.command, iterations:Iterations, kept:Kept, discarded:Discarded,
                     merit_px:Merit, seconds:Seconds, steps:StepDicts}),
    number_or_null(Threshold, ThresholdPx),
    fluent_value(model_fault, Situation, Fault),
    with_fault(Fault, Told.put(threshold_px, ThresholdPx), WithFault),
    with_holds(Plan.program, Situation, HoldErrors, WithFault, WithHolds),
    with_error(Error, WithHolds, Result).

number_or_null(Value, Number) :-
    ( number(Value) -> Number = Value ; Number = null ).

with_fault(none, Dict0, Dict) =>
    Dict = Dict0.
with_fault(wrong(Axis, Share), Dict0, Dict) =>
    Dict = Dict0.put(model_wrong, _{axis:Axis, share:Share}).

with_error(Error, Dict0, Dict) :-
    ( Error == null -> Dict = Dict0 ; Dict = Dict0.put(error, Error) ).

%   Of an approach: the hold points that were planned, and those that were left behind or ended it.
with_holds(session(Planned), Situation, Errors, Dict0, Dict) =>
    fluent_value(holds, Situation, Newest),
    findall(Hold,
            ( nth1(N, Newest, Done),
              hold_dict(Done, Hold0),
              ( nth1(N, Errors, Error) -> with_error(Error, Hold0, Hold) ; Hold = Hold0 ) ),
            NewestDicts),
    reverse(NewestDicts, Holds),
    Dict = Dict0.put(_{planned_holds_m:Planned, holds:Holds}).
with_holds(_, _, _, Dict0, Dict) =>
    Dict = Dict0.

hold_dict(hold(Range, Outcome, Fix), Dict) :-
    fix_dict(Fix, FixDict),
    merit(Fix, Merit),
    Dict = FixDict.put(_{range_m:Range, status:Outcome, merit:Merit}).

images(Decision, Steps, Images) :-
    findall(Image, ( member(Step, Steps), _{image:Image, decision:Decision} :< Step ), Images).

%   A scenario is the simulator's; a recorded stack, a camera and a server of the user's have none.
source(Options, null, Stack) :-
    option(stack(Dir), Options),
    !,
    absolute_file_name(Dir, Stack).
source(Options, null, null) :-
    ( option(camera(_), Options) ; option(image_server(_), Options) ),
    !.
source(Options, Scenario, null) :-
    option(scenario(Scenario), Options).

%   A light that has died is left with no level.
light_dicts(unknown, Lights) =>
    Lights = [].
light_dicts(Device, Lights) =>
    device_lights(Device, Terms),
    maplist(light_dict, Terms, Lights).

light_dict(light(Name, Levels0), _{name:Name, levels:Levels}) :-
    number_or_null(Levels0, Levels).

%   Steps are newest first, as are the errors of the last ones; their dicts are oldest first.  Wanted has the settings that
%   were asked for each image.
step_dicts(Device, Wanted, Steps, Errors, Dicts) :-
    findall(Range, ( member(Step, Steps), arg(9, Step, Range), number(Range) ), Newest),
    reverse(Newest, Oldest),
    list_to_set(Oldest, Ranges),
    findall(Dict,
            ( nth1(N, Steps, Step),
              step_dict(Device, Wanted, Step, Ranges, Dict0),
              ( nth1(N, Errors, Error) -> with_error(Error, Dict0, Dict) ; Dict = Dict0 ) ),
            NewestDicts),
    reverse(NewestDicts, Dicts).

step_dict(Device, Wanted, step(Iteration, Image, Settings, State, Decision, Reason, SetSize, Fix, Range), Ranges, Dict) :-
    settings_dict(Settings, SettingsDict),
    state_words(State, Qualitative),
    settings_words(Device, Settings, Words),
    fix_dict(Fix, FixDict),
    del_dict(covariance, FixDict, _, Quality),
    merit(Fix, Merit),
    reason_words(Reason, ReasonWords),
    Step = Quality.put(_{iteration:Iteration, image:Image, settings:SettingsDict, settings_words:Words,
                         qualitative:Qualitative, decision:Decision, reason:ReasonWords, set_size:SetSize, merit:Merit}),
    (   memberchk(Image-Asked, Wanted),
        Asked \== Settings
    ->  settings_dict(Asked, AskedDict),
        Step1 = Step.put(asked, AskedDict)
    ;   Step1 = Step
    ),
    (   nth1(Hold, Ranges, Range)
    ->  Dict = Step1.put(hold, Hold)
    ;   Dict = Step1
    ).

%   A strategy may give any term for a reason, and where it names a fluent it gives the fluent's value.  The words are those
%   that the terminal shows.
reason_words(Reason, Words) :-
    format(string(Words), "~w", [Reason]).

%!  write_result(+Result, +Folder) is det.

write_result(Result, Folder) :-
    run_file(Folder, 'result.json', File),
    replace_file(File, write_json(Result)).

%!  print_result(+Result) is det.
%
%   On standard output.

print_result(Result) :-
    ( kept_output(Stream) -> true ; Stream = user_output ),
    write_json(Result, Stream),
    flush_output(Stream).

%!  keep_output_for_result is det.
%
%   From now on standard output is for the result alone: what a strategy writes there goes to standard error.

keep_output_for_result :-
    once(stream_property(Stream, alias(user_output))),
    assertz(kept_output(Stream)),
    set_stream(user_error, alias(user_output)),
    set_output(user_error).

write_json(Result, Stream) :-
    json_write_dict(Stream, Result, [width(110)]),
    nl(Stream).

:- module(session_result,
          [ session_result/3,           % +Facts, +Value, -Result
            write_result/2              % +Result, +File
          ]).
:- use_module('../domain/reasoning/device').
:- use_module('../domain/reasoning/merit').
:- use_module('../domain/reasoning/qualitative').
:- use_module(library(apply), [maplist/3]).
:- use_module(library(http/json), [json_write_dict/3]).
:- use_module(library(lists), [member/2, reverse/2]).

/** <module> result.json

The session's outcome as a dict, made from the fluents' values in its last
situation.
*/

:- meta_predicate session_result(+, 2, -).

%!  session_result(+Facts, :Value, -Result) is det.
%
%   Facts is a dict of what the fluents do not know: status, controller, target,
%   seed, command, seconds (a list of Part-Seconds), error (a dict, or null) and
%   threshold_px.  call(Value, Fluent, V) gives the value of a fluent.

session_result(Facts, Value, Result) :-
    call(Value, steps, Newest),
    reverse(Newest, Steps),
    call(Value, best, Best),
    call(Value, device, Device),
    call(Value, merit, Merit),
    call(Value, iteration, Iterations),
    maplist(step_dict(Device), Steps, StepDicts),
    findall(Image, member(step(_, Image, _, _, keep, _, _, _), Steps), Kept),
    findall(Image, member(step(_, Image, _, _, discard, _, _, _), Steps), Discarded),
    fix_dict(Best, Fix),
    dict_pairs(Seconds, seconds, Facts.seconds),
    Base = _{status:Facts.status, controller:Facts.controller, target:Facts.target, seed:Facts.seed,
             iterations:Iterations, kept:Kept, discarded:Discarded, rms_px:Fix.rms_px,
             pose:Fix.pose, covariance:Fix.covariance, seconds:Seconds, steps:StepDicts,
             merit_px:Merit, threshold_px:Facts.threshold_px, uncertainty:Fix.uncertainty,
             supported_fraction:Fix.supported_fraction, lines:Fix.lines, command:Facts.command},
    call(Value, holds, HoldsNewest),
    reverse(HoldsNewest, Holds),
    maplist(hold_dict, Holds, HoldDicts),
    ( HoldDicts == [] -> WithHolds = Base ; WithHolds = Base.put(holds, HoldDicts) ),
    ( is_dict(Facts.error) -> Result = WithHolds.put(error, Facts.error) ; Result = WithHolds ).

step_dict(Device, step(Iteration, Image, Settings, State, Decision, Reason, SetSize, Fix), Dict) :-
    Settings = settings(Levels, Shutter, Aperture),
    state_words(State, Qualitative),
    settings_words(Device, Settings, Words),
    fix_dict(Fix, FixDict),
    merit(Fix, Merit),
    Dict = _{iteration:Iteration, image:Image,
             settings:_{lights:Levels, shutter_s:Shutter, aperture:Aperture},
             settings_words:Words, qualitative:Qualitative, decision:Decision, reason:Reason,
             set_size:SetSize, rms_px:FixDict.rms_px, merit:Merit, pose:FixDict.pose,
             supported_fraction:FixDict.supported_fraction, lines:FixDict.lines}.

hold_dict(hold(Range, Outcome, Fix), Dict) :-
    fix_dict(Fix, FixDict),
    Dict = FixDict.put(_{range_m:Range, status:Outcome}).

fix_dict(none, _{pose:null, covariance:null, rms_px:null, uncertainty:null, supported_fraction:null,
                 lines:[]}).
fix_dict(fix(pose(Rotation, Translation), Covariance,
             quality(Rms, Uncertainty, Support, _, _), Lines),
         _{pose:_{rotation_vector:Rotation, translation:Translation}, covariance:Covariance,
           rms_px:Rms, uncertainty:Uncertainty, supported_fraction:Support, lines:LineDicts}) :-
    maplist(line_dict, Lines, LineDicts).

line_dict(line(Line, Visible, Support, Rms),
          _{line:Line, visible_px:Visible, support:Support, rms_px:Rms}).

%!  write_result(+Result, +File) is det.
%
%   Written beside its place and then moved there, so that a reader never sees half.

write_result(Result, File) :-
    atom_concat(File, '.new', New),
    setup_call_cleanup(open(New, write, Stream, [encoding(utf8)]),
                       ( json_write_dict(Stream, Result, [width(110)]), nl(Stream) ),
                       close(Stream)),
    rename_file(New, File).

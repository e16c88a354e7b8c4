:- module(session_json_terms,
          [ device_term/2,              % +Description, -Device
            settings_dict/2,            % +Settings, -Dict
            statistics_term/2,          % +Dict, -Statistics
            fix_term/2,                 % +Dict, -Fix
            fix_dict/2,                 % +Fix, -Dict
            pose_dict/2                 % +Pose, -Dict
          ]).
/** <module> What changes its form between JSON and the controller's terms

Objects of the wire protocol (docs/protocol.md) and of result.json (docs/result.md) are dicts here.
*/

:- use_module(library(apply), [maplist/3]).

%!  device_term(+Description, -Device) is det.
%
%   A device as of domain/reasoning/device.pl from what `describe` tells of it.

device_term(D, device(Lights, D.shutters_s, D.apertures, Sensor, Reference, D.setting_tolerance)) :-
    maplist(light_term, D.lights, Lights),
    Sensor = sensor(D.camera.gain, D.camera.read_noise_e, D.camera.full_well_e, D.camera.gamma),
    Reference = exposure(D.reference.shutter_s, D.reference.aperture).

light_term(Dict, light(Name, Dict.levels)) :-
    atom_string(Name, Dict.name).

%!  settings_dict(+Settings, -Dict) is det.
%!  settings_dict(-Settings, +Dict) is det.

settings_dict(Settings, Dict), is_dict(Dict) =>
    Settings = settings(Dict.lights, Dict.shutter_s, Dict.aperture).
settings_dict(settings(Levels, Shutter, Aperture), Dict) =>
    Dict = _{lights:Levels, shutter_s:Shutter, aperture:Aperture}.

%!  statistics_term(+Dict, -Statistics) is det.
%
%   As of domain/reasoning/prediction.pl.

statistics_term(S, statistics(S.p50, S.p95, S.dark_fraction, S.saturated_fraction, Blur)) :-
    (   number(S.get(blur_px)) -> Blur = S.blur_px ; Blur = unknown ).

%!  fix_term(+Dict, -Fix) is det.
%
%   A fix as of domain/reasoning/merit.pl, or no_pose, from the result of `estimate`.

fix_term(R, no_pose) :-
    R.pose == null,
    !.
fix_term(R, fix(Pose, R.covariance, Quality, Lines)) :-
    pose_dict(Pose, R.pose),
    Quality = quality(R.rms_px, R.uncertainty, R.supported_fraction, R.score, R.ambiguity),
    maplist(line_term, R.lines, Lines).

line_term(L, line(L.line, L.visible_px, L.support, L.rms_px)).

%!  fix_dict(+Fix, -Dict) is det.
%
%   What result.json tells of a fix; the pose is null for `none`.

fix_dict(none, _{pose:null, covariance:null, rms_px:null, uncertainty:null, supported_fraction:null, score:null,
                 ambiguity:null, lines:[]}).
fix_dict(fix(Pose, Covariance, quality(Rms, Uncertainty, Support, Score, Ambiguity), Lines),
         _{pose:PoseDict, covariance:Covariance, rms_px:Rms, uncertainty:Uncertainty, supported_fraction:Support,
           score:Score, ambiguity:Ambiguity, lines:LineDicts}) :-
    pose_dict(Pose, PoseDict),
    maplist(line_dict, Lines, LineDicts).

line_dict(line(Line, Visible, Support, Rms), _{line:Line, visible_px:Visible, support:Support, rms_px:Rms}).

%!  pose_dict(+Pose, -Dict) is det.
%!  pose_dict(-Pose, +Dict) is det.

pose_dict(pose(Rotation, Translation), Dict), is_dict(Dict) =>
    Rotation = Dict.rotation_vector,
    Translation = Dict.translation.
pose_dict(Pose, Dict) =>
    Pose = pose(Rotation, Translation),
    Dict = _{rotation_vector:Rotation, translation:Translation}.

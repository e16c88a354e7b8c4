:- module(session_described,
          [ described_model/2,          % +Description, -Model
            recorded_frames/2,          % +Description, -Count
            draws/4,                    % +Description, +Seed, ?Where, -Draws
            kept_description/2,         % +Description, -Text
            check_as_begun/4            % +Options, +Folder, +Seed, +Description
          ]).
/** <module> What an image server describes, as far as a session that goes on must find it as it was

Levels are sent without names, and images of another scene are not of the session: where lights, camera or scene are
others, what is recorded would not be what was done.  Description is the answer to `describe`.
*/

:- use_module('../usage_errors', [usage_error/2]).
:- use_module('../folder/run_folder', [run_file/3]).
:- use_module('../../bridge/prolog/json', [json_term/2, json_text/2]).
:- use_module('../../indigolog/online/journal', [journal_entries/3]).
:- use_module(library(apply), [maplist/2, maplist/3]).
:- use_module(library(lists), [member/2, nth1/3]).
:- use_module(library(option), [option/2]).

%!  described_model(+Description, -Model) is semidet.
%
%   The target's model file; of a device without a target, which says null or nothing, none.

described_model(Description, Model) :-
    Target = Description.get(target),
    is_dict(Target),
    Model = Target.get(model).

%!  recorded_frames(+Description, -Count) is det.
%
%   How many images the device has; `inf` where it takes them.

recorded_frames(Description, Count) :-
    (   get_dict(recorded, Description, Count0),
        integer(Count0)
    ->  Count = Count0
    ;   Count = inf
    ).

%!  draws(+Description, +Seed, ?Where, -Draws) is semidet.
%
%   The seed of what is drawn on this scene.  Where is `known` or `unknown`, as the place of the target is; a target that
%   has moved is not where it was.  Fails where nothing is told of a target.

draws(Description, Seed, Where, Draws) :-
    described_model(Description, Model),
    (   SeedPose = Description.target.get(seed_pose),
        is_dict(SeedPose)
    ->  Where = known,
        dict_pairs(SeedPose, _, Scene)
    ;   Where = unknown,
        Scene = []
    ),
    file_base_name(Model, Name),
    term_hash(draws(Seed, Name, Scene), Draws).

%!  kept_description(+Description, -Text) is det.
%
%   What the run folder keeps of it.

kept_description(Description, Text) :-
    findall(Key-Value, ( kept_key(Key), get_dict(Key, Description, Value) ), Pairs),
    dict_pairs(Kept, described, Pairs),
    json_text(Kept, Text).

kept_key(lights).
kept_key(Key) :- settings_key(Key).
kept_key(Key) :- part_key(Key).

settings_key(shutters_s).
settings_key(apertures).
settings_key(focal_lengths_mm).
settings_key(focuses_m).

part_key(camera).
part_key(reference).

%!  check_as_begun(+Options, +Folder, +Seed, +Description) is det.
%
%   A session that goes on has the scene and the device that it was begun with; one that an older version began may not
%   tell of its device.
%
%   @error usage_error(Message), which names the first difference

check_as_begun(Options, Folder, Seed, Description) :-
    option(resume(_), Options),
    !,
    check_same_scene(Folder, Seed, Description),
    (   option(described(Text), Options),
        json_term(Text, Kept),
        difference(Kept, Description, Words)
    ->  usage_error("--resume: the image server describes another device than the session in ~w was begun with: ~w",
                    [Folder, Words])
    ;   true
    ).
check_as_begun(_, _, _, _).

check_same_scene(Folder, Seed, Description) :-
    run_file(Folder, 'history.pl', Journal),
    journal_entries(Journal, begun(_, Begun), _),
    draws(Description, Seed, known, Draws),
    Draws =\= Begun,
    !,
    usage_error("--resume: the image server shows another target or scene than the session in ~w was begun with", [Folder]).
check_same_scene(_, _, _).

%   What only one of the two tells is no difference: it may be of another version.
difference(Kept, Description, Words) :-
    told(Kept, What, Then),
    told(Description, What, Now),
    \+ same(Then, Now),
    !,
    atomic_list_concat(What, Name),
    value_words(Then, ThenWords),
    value_words(Now, NowWords),
    format(string(Words), "~w: ~w; at its beginning ~w", [Name, NowWords, ThenWords]).

%   told(+Description, ?What, -Value): What is a list of words.
told(Description, [lights], Names) :-
    findall(Name, ( member(Light, Description.lights), get_dict(name, Light, Name) ), Names).
told(Description, [Key, ' of the light ', Name, ' (', N, ')'], Value) :-
    nth1(N, Description.lights, Light),
    Name = Light.name,
    member(Key, [levels, position, power]),
    get_dict(Key, Light, Value).
told(Description, [Key], Value) :-
    settings_key(Key),
    get_dict(Key, Description, Value).
told(Description, [Part, ' ', Key], Value) :-
    part_key(Part),
    get_dict(Part, Description, Dict),
    is_dict(Dict),
    get_dict(Key, Dict, Value).

same(Then, Now), number(Then), number(Now) =>
    Then =:= Now.
same(Then, Now), is_list(Then), is_list(Now) =>
    maplist(same, Then, Now).
same(Then, Now) =>
    Then == Now.

value_words(Values, Words), is_list(Values) =>
    atomic_list_concat(Values, ', ', Words).
value_words(Value, Words) =>
    Words = Value.

:- module(domain_surprises,
          [ light_changed/1,            % +Cause
            telling_settings/5,         % +Device, +Readings, +Cause, +Tested, -Settings
            statistics_seen/2,          % +Seen, -Statistics
            settings_seen/3,            % +Seen, +Asked, -Settings
            event_seen/2,               % +Seen, -Event
            repetition_seen/2,          % +Seen, -Image
            remark/3,                   % +Surprise, +Doubt, -Text
            cause_words/2               % +Cause, -Text
          ]).
/** <module> Images that are not as foreseen

A cause is target_moved, sun_changed, light_dead(Light), lights_swapped(Light1, Light2), lights by their names, or
in_the_way.  The vision server weighs them; where it is not sure, an image tells that is taken under the right light.
What two images and more tell together is model_wrong(Axis, Share): the model is by Share too long along x, y or z.
*/

:- use_module(device).
:- use_module(library(apply), [maplist/2]).
:- use_module(library(lists), [append/3, last/2, member/2, nth1/3, reverse/2, same_length/2]).

%!  light_changed(+Cause) is semidet.
%
%   Light goes together with settings in another way than before.

light_changed(sun_changed).
light_changed(light_dead(_)).
light_changed(lights_swapped(_, _)).

%!  telling_settings(+Device, +Readings, +Cause, +Tested, -Settings) is semidet.
%
%   Settings whose image would tell whether Cause has happened, but for those that were Tested: the last image again
%   without the suspected light, which is the same image if the light is dead; the first image again, in which nothing
%   can differ but what has changed, or of what is in the way the one that shows most; one before the doubt with suspected
%   lights in each other's place, which is the same image if they are swapped; suspected lights alone; no light at all.
%   Readings are newest first.

telling_settings(Device, Readings, Cause, Tested, Settings) :-
    before(Readings, Tested, Before),
    (   Cause = lights_swapped(One, Other),
        exchanged_before(Device, One, Other, Before, Settings)
    ;   Cause = in_the_way,
        shown_before(Before, Settings)
    ;   telling(Cause, Device, Readings, Settings)
    ),
    \+ memberchk(Settings, Tested),
    !.

telling(light_dead(Light), Device, Readings, settings(Levels, Shutter, Aperture)) :-
    light_number(Device, Light, N),
    once(( member(reading(settings(Lit, Shutter, Aperture), _), Readings),
           put_out(N, Lit, Levels) )).
telling(light_dead(_), _, Readings, First) :-
    first(Readings, First).
telling(light_dead(Light), Device, Readings, Settings) :-
    alone(Device, Light, Readings, Settings).
telling(sun_changed, _, Readings, First) :-
    first(Readings, First).
telling(sun_changed, Device, Readings, settings(Levels, Shutter, Aperture)) :-
    first(Readings, settings(_, Shutter, Aperture)),
    full_levels(Device, Full),
    same_length(Full, Levels),
    maplist(=(0), Levels).
telling(lights_swapped(Light, _), Device, Readings, Settings) :-
    alone(Device, Light, Readings, Settings).
telling(lights_swapped(_, Light), Device, Readings, Settings) :-
    alone(Device, Light, Readings, Settings).
telling(lights_swapped(_, _), _, Readings, First) :-
    first(Readings, First).

first(Readings, First) :-
    last(Readings, reading(First, _)).

alone(Device, Light, Readings, settings(Levels, Shutter, Aperture)) :-
    first(Readings, settings(_, Shutter, Aperture)),
    light_number(Device, Light, N),
    only_light(Device, N, Levels).

%   The N-th level, which is not 0, as 0.
put_out(1, [Level|Rest], [0|Rest]) :-
    !,
    Level > 0.
put_out(N, [Level|Rest0], [Level|Rest]) :-
    N1 is N - 1,
    put_out(N1, Rest0, Rest).

%   Of what was read before the doubt, newest first.
before(Readings, Tested, Before) :-
    same_length(Tested, Tests),
    append([_|Tests], Before, Readings).

%   The settings of an image from before the doubt, first of the one that shows most of the target, neither dark nor saturated.
shown_before(Before, Again) :-
    reverse(Before, Oldest),
    findall(Unseen-Settings,
            ( member(reading(Settings, statistics(_, _, Dark, Saturated, _)), Oldest),
              Unseen is Dark + Saturated ),
            Shown),
    keysort(Shown, BestFirst),
    member(_-Again, BestFirst).

%   An image from before the doubt with the two in each other's place: the same image, if they are swapped.
exchanged_before(Device, One, Other, Before, settings(Levels, Shutter, Aperture)) :-
    light_number(Device, One, N),
    light_number(Device, Other, M),
    member(reading(settings(Lit, Shutter, Aperture), _), Before),
    exchanged(Device, N, M, Lit, Levels),
    Levels \== Lit,
    exchanged(Device, N, M, Levels, Lit).

%   The N-th and the M-th light, each at the level nearest to the other's share of its full light.  Where one has few levels,
%   that is no exchange, and back again gives others.
exchanged(Device, N, M, Lit, Levels) :-
    level_fractions(Device, Lit, Shares),
    nth1(N, Shares, One),
    nth1(M, Shares, Other),
    full_levels(Device, Full),
    findall(Level,
            ( nth1(K, Lit, Own), nth1(K, Full, Top),
              ( K =:= N -> Level is round(Other * Top) ; K =:= M -> Level is round(One * Top) ; Level = Own ) ),
            Levels).

light_number(Device, Light, N) :-
    device_lights(Device, Lights),
    nth1(N, Lights, light(Light, Levels)),
    Levels \= dead(_).

%!  statistics_seen(+Seen, -Statistics) is det.
%!  settings_seen(+Seen, +Asked, -Settings) is det.
%!  event_seen(+Seen, -Event) is semidet.
%!  repetition_seen(+Seen, -Image) is det.
%
%   Of what a capture senses: an image's statistics, alone or with the event that they come with as told(Statistics, Event);
%   either in under(Settings, Seen) where the image was taken under other settings than those that were asked for; and all
%   that in same_as(Image, Seen) where it is the very picture of an earlier Image, which is `none` of others.

statistics_seen(same_as(_, Seen), Statistics) =>
    statistics_seen(Seen, Statistics).
statistics_seen(under(_, Seen), Statistics) =>
    statistics_seen(Seen, Statistics).
statistics_seen(told(Statistics0, _), Statistics) =>
    Statistics = Statistics0.
statistics_seen(Statistics0, Statistics) =>
    Statistics = Statistics0.

settings_seen(same_as(_, Seen), Asked, Settings) =>
    settings_seen(Seen, Asked, Settings).
settings_seen(under(Settings0, _), _, Settings) =>
    Settings = Settings0.
settings_seen(_, Asked, Settings) =>
    Settings = Asked.

event_seen(same_as(_, Seen), Event) :-
    event_seen(Seen, Event).
event_seen(under(_, Seen), Event) :-
    event_seen(Seen, Event).
event_seen(told(_, Event), Event).

repetition_seen(same_as(Image0, _), Image) =>
    Image = Image0.
repetition_seen(_, Image) =>
    Image = none.

%!  remark(+Surprise, +Doubt, -Text) is det.
%
%   What is to be said of an image: nothing, or why it is, or may be, not as foreseen.

remark(none, none, '') :-
    !.
remark(none, Cause, Text) :-
    !,
    cause_words(Cause, Words),
    format(atom(Text), "not as foreseen: perhaps ~w", [Words]).
remark(because(_, model_wrong(Axis, Share)), _, Text) :-
    !,
    cause_words(model_wrong(Axis, Share), Text).
remark(because(_, Cause), _, Text) :-
    cause_words(Cause, Words),
    format(atom(Text), "not as foreseen: ~w", [Words]).

%!  cause_words(+Cause, -Text) is det.

cause_words(target_moved, 'the target has moved').
cause_words(sun_changed, 'the sun has changed').
cause_words(in_the_way, 'something is in the way').
cause_words(model_wrong(Axis, Share), Text) :-
    ( Share > 0 -> Long = long ; Long = short ),
    Percent is 100 * abs(Share),
    format(atom(Text), "the model does not fit, it is about ~1f % too ~w along ~w", [Percent, Long, Axis]).
cause_words(light_dead(Light), Text) :-
    format(atom(Text), "the light ~w is dead", [Light]).
cause_words(lights_swapped(One, Other), Text) :-
    format(atom(Text), "the lights ~w and ~w are swapped", [One, Other]).

:- module(session_option_rules,
          [ approach_ranges/3,          % +Options, -First, -Contact
            check_of_use/1,             % +Given
            check_options/1             % +Options
          ]).
/** <module> What options must not be, and which need or exclude each other */

:- autoload('../../bridge/prolog/keys', [client_keys/4]).
:- use_module('../usage_errors', [dashes/2, usage_error/2]).
:- use_module(library(lists), [append/3, member/2]).
:- use_module(library(option), [option/2, option/3]).

%!  check_of_use(+Given) is det.
%
%   Refuse what was given and would change nothing: who gives it expects something of it.
%
%   @error usage_error(Message) the option, and what to do

check_of_use(Given) :-
    forall(( given_twice(Given, Name, Why) ; \+ option(resume(_), Given), of_no_use(Given, Name, Why) ),
           ( dashes(Name, Dashed), usage_error("--~w ~w", [Dashed, Why]) )).

given_twice(Given, Name, 'is given more than once, with other values: leave all but one out') :-
    append(_, [First|Later], Given),
    First =.. [Name, Value],
    Other =.. [Name, Value1],
    member(Other, Later),
    Value1 \== Value.

of_no_use(Given, Name, 'is of --approach: give that too, or leave it out') :-
    member(Name, [first_range, contact_range]),
    given(Name, Given),
    \+ option(approach(true), Given).
of_no_use(Given, idle_s, 'is of --keep-servers: give that too, or leave it out') :-
    given(idle_s, Given), \+ option(keep_servers(true), Given).
of_no_use(Given, keep_servers, 'has no server to keep: --image-server and --vision-server name both') :-
    option(keep_servers(true), Given), given(image_server, Given), given(vision_server, Given).
of_no_use(Given, scenario, Why) :-
    given(scenario, Given),
    member(Name, [stack, camera, image_server]),
    given(Name, Given),
    dashes(Name, Dashed),
    format(atom(Why), "is of the simulator, and the images come from --~w: leave one of them out", [Dashed]).
of_no_use(Given, seed_pose, 'says where to look, and --first-sight looks everywhere: leave one of them out') :-
    given(seed_pose, Given),
    option(first_sight(true), Given).
of_no_use(Given, explain, 'says what --quiet leaves out: give one of them') :-
    option(explain(true), Given), option(quiet(true), Given).
of_no_use(Given, json, 'prints a result, and --dry-run comes to none: leave one of them out') :-
    option(json(true), Given), option(dry_run(true), Given).

given(Name, Given) :-
    given(Name, Given, _).

given(Name, Given, Value) :-
    Option =.. [Name, Value],
    option(Option, Given).

%!  check_options(+Options) is det.
%
%   With the defaults filled in.
%
%   @error usage_error(Message) what must not be, and what to do

check_options(Options) :-
    forall(rule(Options, Format, Args), usage_error(Format, Args)).

% What must not be, and what to say then.
rule(Options, "--out: the name of the folder is missing", []) :-
    option(out(''), Options).
rule(Options, "--out: ~w is a file; name a folder", [File]) :-
    option(out(File), Options), exists_file(File).
rule(Options, "--~w must be a positive number of ~w, not ~w", [Dashed, Unit, Number]) :-
    member(Name-Unit, [threshold-pixels, idle_s-seconds, first_range-metres, contact_range-metres]),
    given(Name, Options, Number),
    \+ ( Number > 0, Number < inf ),     % nor is 1.5NaN
    dashes(Name, Dashed).
rule(Options, "--max-iterations must be at least 1, not ~w", [N]) :-
    option(max_iterations(N), Options), N < 1.
rule(Options, "--seed must be a whole number from 0 to ~w, not ~w", [Most, Seed]) :-
    option(seed(Seed), Options), most_seed(Most), \+ between(0, Most, Seed).
rule(Options, "--~w and --~w exclude each other: each says where the images come from", [First, Second]) :-
    findall(Dashed,
            ( member(Name, [stack, image_server, camera]), given(Name, Options), dashes(Name, Dashed) ),
            [First, Second|_]).
rule(Options, "--keep-servers and --camera exclude each other: a camera and lights are not kept switched on", []) :-
    option(keep_servers(true), Options), option(camera(_), Options).
rule(Options, "--lights needs --camera: light is only worth what a camera sees of it", []) :-
    option(lights(_), Options), \+ option(camera(_), Options).
rule(Options, "--camera needs --target: cube, fixture, satellite or a model file", []) :-
    option(camera(_), Options), \+ option(target(_), Options).
rule(Options, "--approach needs the simulator (or an image server that can move the target), not --stack or --camera", []) :-
    option(approach(true), Options), ( option(stack(_), Options) ; option(camera(_), Options) ).
rule(Options, "--stack has its own target: leave --target out, or name a model file", []) :-
    option(stack(_), Options), option(target(Name), Options), \+ exists_file(Name).
rule(Options, "--unit needs --target FILE: it is the unit of the numbers in that file", []) :-
    option(unit(_), Options), \+ ( option(target(File), Options), exists_file(File) ).
rule(Options, "--first-range ~w must be more than --contact-range, ~w m: give another of them", [First, Contact]) :-
    approach_ranges(Options, First, Contact),
    Contact >= First.
rule(Options, "--~w: '~w' is not an endpoint such as tcp://127.0.0.1:5555 or ipc:///tmp/vision", [Dashed, Endpoint]) :-
    member(Name, [image_server, vision_server]),
    given(Name, Options, Endpoint),
    \+ endpoint(Endpoint),
    dashes(Name, Dashed).
rule(Options, "--~w: no file '~w'", [Dashed, File]) :-
    member(Name, [camera_model, seed_pose]),
    given(Name, Options, File),
    \+ exists_file(File),
    dashes(Name, Dashed).
rule(Options, "--~w: there is no '~w'", [Name, Device]) :-
    member(Name, [camera, lights]),
    given(Name, Options, Device),
    \+ access_file(Device, exist).
rule(Options, "--keys: others can read ~w, which is a secret: chmod 600 ~w", [File, File]) :-
    option(keys(Dir), Options), exists_directory(Dir),
    catch(( client_keys(Dir, controller, vision_server, _), fail ), error(Error, _), true),
    nonvar(Error),
    Error = open_secret(File).
rule(Options, "--keys: no ~w key in ~w; make keys with python -m bridge keys DIR", [Which, File]) :-
    option(keys(Dir), Options), exists_directory(Dir),
    member(Server, [image_server, vision_server]),
    catch(( client_keys(Dir, controller, Server, _), fail ), error(no_key(File, Which), _), true).
rule(Options, "--~w: no folder '~w'", [Name, Dir]) :-
    member(Name, [stack, keys]),
    given(Name, Options, Dir),
    \+ exists_directory(Dir).

%   Where a server may listen: a socket file, or a port of a machine.
endpoint(Endpoint) :-
    atom_concat('ipc://', Path, Endpoint),
    Path \== ''.
endpoint(Endpoint) :-
    atom_concat('tcp://', Address, Endpoint),
    sub_atom(Address, Before, 1, After, ':'),
    Before > 0,
    sub_atom(Address, _, After, 0, Port),
    catch(atom_number(Port, Number), error(_, _), fail),
    between(1, 65535, Number).

%!  approach_ranges(+Options, -First, -Contact) is det.
%
%   The first and the last hold point of an approach, in metres.

approach_ranges(Options, First, Contact) :-
    option(first_range(First), Options, 1.5),
    option(contact_range(Contact), Options, 0.3).

most_seed(0x7fffffffffffffff).          % what the servers' messages hold: 64 bits with a sign

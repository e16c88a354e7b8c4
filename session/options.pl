:- module(session_options,
          [ session_options/2           % +Argv, -Options
          ]).
/** <module> The command line of a session

`swipl main.pl [options]`.  What a user can get wrong is said in one line: what, where, what to do.
*/

:- use_module(option_rules, [check_of_use/1, check_options/1]).
:- use_module(resumption, [resumed_options/3]).
:- use_module(usage, [dashes/2, did_you_mean/3, usage_error/2]).
:- use_module(library(apply), [foldl/4]).
:- use_module(library(lists), [memberchk/2]).
:- use_module(library(main), [argv_options/4, argv_usage/1]).
:- use_module(library(memfile), [free_memory_file/1, memory_file_to_string/2, new_memory_file/1, open_memory_file/3]).
:- use_module(library(option), [merge_options/3, option/2]).

opt_type(controller,     controller,     atom).
opt_type(target,         target,         atom).
opt_type(unit,           unit,           oneof([m, cm, mm, in])).
opt_type(scenario,       scenario,       atom).
opt_type(stack,          stack,          atom).
opt_type(camera,         camera,         atom).
opt_type(lights,         lights,         atom).
opt_type(camera_model,   camera_model,   atom).
opt_type(seed_pose,      seed_pose,      atom).
opt_type(first_sight,    first_sight,    boolean).
opt_type(image_server,   image_server,   atom).
opt_type(vision_server,  vision_server,  atom).
opt_type(keys,           keys,           atom).
opt_type(keep_servers,   keep_servers,   boolean).
opt_type(idle_s,         idle_s,         number).
opt_type(matcher,        matcher,        oneof([search, genetic])).
opt_type(threshold,      threshold,      number).
opt_type(max_iterations, max_iterations, integer).
opt_type(seed,           seed,           integer).
opt_type(instead,        instead,        atom).
opt_type(out,            out,            atom).
opt_type(resume,         resume,         atom).
opt_type(approach,       approach,       boolean).
opt_type(first_range,    first_range,    number).
opt_type(contact_range,  contact_range,  number).
opt_type(dry_run,        dry_run,        boolean).
opt_type(explain,        explain,        boolean).
opt_type(view,           view,           boolean).
opt_type(report,         report,         boolean).
opt_type(json,           json,           boolean).
opt_type(quiet,          quiet,          boolean).

opt_meta(controller,     'NAME_OR_FILE').
opt_meta(target,         'NAME_OR_FILE').
opt_meta(unit,           'UNIT').
opt_meta(scenario,       'NAME_OR_FILE').
opt_meta(stack,          'DIR').
opt_meta(camera,         'DEV_OR_TOML').
opt_meta(lights,         'DEV_OR_TOML').
opt_meta(camera_model,   'TOML').
opt_meta(seed_pose,      'TOML').
opt_meta(image_server,   'ENDPOINT').
opt_meta(vision_server,  'ENDPOINT').
opt_meta(keys,           'DIR').
opt_meta(idle_s,         'S').
opt_meta(matcher,        'NAME').
opt_meta(threshold,      'PX').
opt_meta(max_iterations, 'N').
opt_meta(seed,           'N').
opt_meta(instead,        'SETTINGS').
opt_meta(out,            'DIR').
opt_meta(resume,         'DIR').
opt_meta(first_range,    'M').
opt_meta(contact_range,  'M').

opt_help(help(header), "\nOne session: find the pose of a docking target by choosing lights and camera.\n").
opt_help(help(usage), " [options]").
opt_help(controller,     "Strategy: heuristic (default), informed, greedy, simple, auto_exposed, gradient, fused, fixed, or a Golog file").
opt_help(target,         "cube (default; for --approach: fixture), fixture, satellite, or a model file (.cao .obj .stl .ply .glb); --camera has no default").
opt_help(unit,           "Unit of the numbers in the model file of --target: m (default), cm, mm or in").
opt_help(scenario,       "Light conditions on the simulator, or a TOML file (default: nominal; for --approach: approach)").
opt_help(stack,          "Replay a folder of recorded light stacks instead of simulating").
opt_help(camera,         "Use a V4L2 camera: its device, such as /dev/video0, or its TOML file").
opt_help(lights,         "With --camera: serial device of the lights, such as /dev/ttyUSB0, or their TOML file").
opt_help(camera_model,   "TOML file with [camera], where the image server has none").
opt_help(seed_pose,      "TOML file with [target.seed_pose], where the image server has none").
opt_help(first_sight,    "Look for the target everywhere, whatever seed pose is known").
opt_help(image_server,   "Use a running image server, e.g. tcp://127.0.0.1:5555").
opt_help(vision_server,  "Use a running vision server").
opt_help(keys,           "CURVE keys of the servers and of the controller, for servers on a network").
opt_help(keep_servers,   "Let servers stay for later sessions with this option, and use those that stayed").
opt_help(idle_s,         "Seconds without a request after which servers that stay end (default: 600)").
opt_help(matcher,        "search (default) or genetic, the paper's").
opt_help(threshold,      "Stop when the merit, in pixels, is under this (default: calibrated)").
opt_help(max_iterations, "Stop after this many images (default: 10)").
opt_help(seed,           "Seed of every random draw (default: 1)").
opt_help(instead,        "What if: take one image under other settings, e.g. 'i3: left 7 top 0, 1/60 s, f/4'").
opt_help(out,            "Run folder (default: runs/<time>-<controller>-<target>)").
opt_help(resume,         "Go on with an interrupted session from its run folder").
opt_help(approach,       "Dock: come closer by hold points, each on a trustworthy pose").
opt_help(first_range,    "First hold point of --approach, in metres (default: 1.5)").
opt_help(contact_range,  "Last hold point of --approach, in metres (default: 0.3)").
opt_help(dry_run,        "Check everything, say what would be done, do nothing").
opt_help(explain,        "Say why each setting is chosen and each image kept or discarded").
opt_help(view,           "Show the session in a browser while it runs: open the address that is printed").
opt_help(report,         "Write report.html at the end (default: true; --no-report leaves it out)").
opt_help(json,           "Print result.json on standard output, and nothing else there").
opt_help(quiet,          "No live lines; the result is printed all the same").
opt_help(help(footer), "\nExit status: 0 pose found, 3 finished without reaching the threshold, 2 bad usage or input,\n4 a device or server failed for good, 130/143 stopped by Ctrl-C/SIGTERM.\n").

%   An approach ends where a cube fills the frame: the fixture still shows edges there.
defaults(Given, [target(fixture), scenario(approach)|Defaults]) :-
    option(approach(true), Given),
    !,
    defaults(Defaults).
defaults(Given, [scenario(nominal)|Defaults]) :-
    ( option(stack(_), Given) ; option(image_server(_), Given) ; option(camera(_), Given) ),
    !,
    defaults(Defaults).
defaults(_, [target(cube), scenario(nominal)|Defaults]) :-
    defaults(Defaults).

defaults([ keep_servers(false), idle_s(600), controller(heuristic), matcher(search), max_iterations(10), seed(1),
           first_sight(false), approach(false), first_range(1.5), contact_range(0.3), dry_run(false), explain(false),
           view(false), report(true), json(false), quiet(false) ]).

%!  session_options(+Argv, -Options) is det.
%
%   Options as a list with the defaults filled in.  `--help` prints the usage and
%   halts.
%
%   @error usage_error(Message) what is wrong with the command line

session_options(Argv, _) :-
    ( memberchk('--help', Argv) ; memberchk('-h', Argv) ),
    !,
    usage(Text),
    catch(write(Text), error(io_error(write, _), _), true),      % who reads may have seen enough
    halt(0).
session_options(Argv, Options) :-
    catch(argv_options(session_options:Argv, Positional, Given, []), Error, bad_usage(Error)),
    (   Positional = [Word|_]
    ->  usage_error("unexpected argument '~w'; options begin with -- (see --help)", [Word])
    ;   true
    ),
    check_of_use(Given),
    begun_with(Given, Begun),
    defaults(Begun, Defaults),
    merge_options(Begun, Defaults, Options),
    check_options(Options).

%   The usage, with the names of options as they are written on a command line.
usage(Text) :-
    stream_property(Errors, alias(user_error)),
    setup_call_cleanup(
        new_memory_file(File),
        ( setup_call_cleanup(
              ( open_memory_file(File, write, Stream), set_stream(Stream, alias(user_error)) ),
              argv_usage(session_options:[]),
              ( set_stream(Errors, alias(user_error)), close(Stream) )),
          memory_file_to_string(File, Underscored) ),
        free_memory_file(File)),
    findall(Name, opt_type(Name, _, _), Names),
    foldl(with_dashes, Names, Underscored, Text).

with_dashes(Name, Text0, Text) :-
    atomic_list_concat(['--', Name], Underscored),
    written(Name, Written),
    atomic_list_concat(Parts, Underscored, Text0),
    atomic_list_concat(Parts, Written, Text).

%   An option as it is written on a command line.
written(Name, Written) :-
    dashes(Name, Dashed),
    atom_concat('--', Dashed, Written).

%   A session that is resumed has its options from its folder.
begun_with(Given, Begun) :-
    option(resume(Folder), Given),
    !,
    (   Folder \== '',
        exists_directory(Folder)
    ->  resumed_options(Given, Folder, Begun)
    ;   usage_error("--resume: no folder '~w'", [Folder])
    ).
begun_with(Given, Given).

bad_usage(error(Formal, _)) :-
    usage_text(Formal, Text),
    !,
    usage_error("~s (see --help)", [Text]).
bad_usage(Error) :-
    throw(Error).

usage_text(opt_error(unknown_option(_:Option)), Text) :-
    findall(Known, ( opt_type(Name, _, _), written(Name, Known) ), All),
    written(Option, Given),
    did_you_mean(Given, All, Hint),
    ( Hint == '' -> Stop = '' ; Stop = '.' ),
    format(codes(Text), "unknown option ~w~w~w", [Given, Stop, Hint]).
usage_text(opt_error(missing_value(Option, _)), Text) :-
    dashes(Option, Dashed),
    format(codes(Text), "--~w needs a value", [Dashed]).
usage_text(opt_error(value_type(Option, Type, Value)), Text) :-
    dashes(Option, Dashed),
    type_words(Type, Words),
    (   Type = oneof(Names), did_you_mean(Value, Names, Hint), Hint \== '' -> Stop = '.'
    ;   Hint = '', Stop = ''
    ),
    format(codes(Text), "--~w: '~w' is not ~w~w~w", [Dashed, Value, Words, Stop, Hint]).

type_words(number, "a number").
type_words(integer, "a whole number").
type_words(boolean, "true or false").
type_words(oneof(Names), Words) :-
    atomic_list_concat(Names, ', ', Joined),
    format(string(Words), "one of ~w", [Joined]).

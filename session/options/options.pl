:- module(session_options,
          [ session_options/2           % +Argv, -Options
          ]).
/** <module> The command line of a session

`swipl main.pl [options]`.  What a user can get wrong is said in one line: what, where, what to do.
*/

:- use_module(option_rules, [check_of_use/1, check_options/1]).
:- autoload('../folder/resumption', [again_options/3, resumed_options/3]).
:- use_module('../installation', [installation_names/3, installation_version/1, installed_command/0]).
:- use_module('../usage_errors', [dashes/2, did_you_mean/3, usage_error/2]).
:- autoload(library(apply), [foldl/4]).
:- use_module(library(lists), [memberchk/2]).
:- use_module(library(main), [argv_options/4]).
:- use_module(library(option), [merge_options/3, option/2]).

%   known(Name, Type, Value, Help): an option; Value is what its value is called, '' for a switch.
known(controller, atom, 'NAME_OR_FILE',
      "Strategy: ~w (default: heuristic), or a Golog file").
known(target, atom, 'NAME_OR_FILE',
      "cube (default; for --approach: fixture), fixture, satellite, or a model file (.cao .obj .stl .ply .glb .gltf); --camera has no default").
known(unit, oneof([m, cm, mm, in]), 'UNIT',
      "Unit of the numbers in the model file of --target: m (default), cm, mm or in").
known(scenario, atom, 'NAME_OR_FILE',
      "Light conditions on the simulator, or a TOML file (default: nominal; for --approach: approach)").
known(stack, atom, 'DIR', "Replay a folder of recorded light stacks instead of simulating").
known(camera, atom, 'DEV_OR_TOML', "Use a V4L2 camera: its device, such as /dev/video0, or its TOML file").
known(lights, atom, 'DEV_OR_TOML',
      "With --camera: serial device of the lights, such as /dev/ttyUSB0, or their TOML file").
known(camera_model, atom, 'FILE', "File with [camera], or of OpenCV, ROS, Kalibr or ViSP; before what the image server has").
known(seed_pose, atom, 'TOML', "TOML file with [target.seed_pose], used before the image server's").
known(first_sight, boolean, '', "Look for the target everywhere, whatever seed pose is known").
known(image_server, atom, 'ENDPOINT', "Use a running image server, e.g. tcp://127.0.0.1:5555").
known(vision_server, atom, 'ENDPOINT', "Use a running vision server").
known(keys, atom, 'DIR', "CURVE keys of the servers and of the controller, for servers on a network").
known(keep_servers, boolean, '', "Let servers stay for later sessions with this option, and use those that stayed").
known(idle_s, number, 'S', "Seconds after the last session's end until servers that stay end (default: 600)").
known(matcher, oneof([search, genetic]), 'NAME', "search (default) or genetic, the paper's").
known(threshold, number, 'PX', "Stop when the merit, in pixels, is under this (default: calibrated)").
known(max_iterations, integer, 'N', "Stop after this many images (default: 10)").
known(seed, integer, 'N', "Seed of every random draw (default: 1)").
known(instead, atom, 'SETTINGS', "What if: take one image under other settings, e.g. 'i3: left 7 top 0, 1/60 s, f/4'").
known(out, atom, 'DIR', "Run folder (default: runs/<time>-<controller>-<target>, here)").
known(resume, atom, 'DIR', "Go on with an interrupted session from its run folder").
known(again, atom, 'DIR', "Do the session of a run folder again, but for the options that are given").
known(approach, boolean, '', "Dock: come closer by hold points, each on a trustworthy pose").
known(first_range, number, 'M', "First hold point of --approach, in metres (default: 1.5, of large targets more)").
known(contact_range, number, 'M', "Last hold point of --approach, in metres (default: 0.3, of large targets more)").
known(dry_run, boolean, '', "Check everything, say what would be done, do nothing").
known(explain, boolean, '', "Say why each setting is chosen and each image kept or discarded").
known(view, boolean, '', "Show the session in a browser while it runs: open the address that is printed").
known(report, boolean, '', "Write report.html at the end (default: true; --no-report leaves it out)").
known(json, boolean, '', "Print result.json on standard output, and nothing else there").
known(quiet, boolean, '', "No live lines; the result is printed all the same").
known(version, boolean, '', "Print the version").

%   As library(main) asks for them.
opt_type(Name, Name, Type) :-
    known(Name, Type, _, _).

opt_meta(Name, Value) :-
    known(Name, _, Value, _),
    Value \== ''.

opt_help(help(header), "\nOne session: find the pose of a docking target by choosing lights and camera.\n").
opt_help(help(usage), " [options]").
opt_help(Name, Help) :-
    known(Name, _, _, Text),
    (   Name == controller
    ->  installation_names('domain/controllers', pl, Names),
        atomic_list_concat(Names, ', ', Listed),
        format(atom(Help), Text, [Listed])
    ;   Help = Text
    ).
opt_help(help(footer), "\nExit status: 0 pose found, 3 finished without reaching the threshold,\n2 bad usage or input, 4 a device or server failed for good,\n130/143 stopped by Ctrl-C/SIGTERM.\n").

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
           first_sight(false), approach(false), dry_run(false), explain(false),
           view(false), report(true), json(false), quiet(false) ]).

%!  session_options(+Argv, -Options) is det.
%
%   Options as a list with the defaults filled in.  `--help` prints the usage, `--version` the version, and
%   halts.
%
%   @error usage_error(Message) what is wrong with the command line

session_options(Argv, _) :-
    ( memberchk('--help', Argv) ; memberchk('-h', Argv) ),
    !,
    usage(Text),
    catch(write(Text), error(io_error(write, _), _), true),      % who reads may have seen enough
    halt(0).
session_options(Argv, _) :-
    memberchk('--version', Argv),
    !,
    installation_version(Version),
    format("lights-and-camera ~w~n", [Version]),
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
    phrase(prolog:message(opt_usage(session_options)), Lines),
    with_output_to(string(Underscored), print_message_lines(current_output, '', Lines)),
    findall(Name, known(Name, _, _, _), Names),
    foldl(with_dashes, Names, Underscored, Dashed),
    named_as_called(Dashed, Text).

%   An installed copy is not called as the library has it, by the file.
named_as_called(Text0, Text) :-
    installed_command,
    atomic_list_concat([Before, Called], 'Usage: ', Text0),
    sub_atom(Called, _, _, After, ' [options]'),
    !,
    sub_atom(Called, _, After, 0, Rest),
    atomic_list_concat([Before, 'Usage: lights-and-camera [options]', Rest], Text).
named_as_called(Text, Text).

with_dashes(Name, Text0, Text) :-
    atomic_list_concat(['--', Name], Underscored),
    written(Name, Written),
    atomic_list_concat(Parts, Underscored, Text0),
    atomic_list_concat(Parts, Written, Text).

%   An option as it is written on a command line.
written(Name, Written) :-
    dashes(Name, Dashed),
    atom_concat('--', Dashed, Written).

%   A session that is resumed, or done again, has its options from its folder.
begun_with(Given, Begun) :-
    option(resume(Folder), Given),
    !,
    must_be_folder(resume, Folder),
    resumed_options(Given, Folder, Begun).
begun_with(Given, Begun) :-
    option(again(Folder), Given),
    !,
    must_be_folder(again, Folder),
    again_options(Given, Folder, Begun).
begun_with(Given, Given).

must_be_folder(Name, Folder) :-
    (   Folder \== '',
        exists_directory(Folder)
    ->  true
    ;   usage_error("--~w: no folder '~w'", [Name, Folder])
    ).

bad_usage(error(Formal, _)) :-
    usage_text(Formal, Text),
    !,
    usage_error("~s (see --help)", [Text]).
bad_usage(Error) :-
    throw(Error).

usage_text(opt_error(unknown_option(_:Option)), Text) :-
    findall(Known, ( known(Name, _, _, _), written(Name, Known) ), All),
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

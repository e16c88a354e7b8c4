:- module(session_plan,
          [ session_plan/2,             % +Options, -Plan
            within_reach/4              % +Options, +Device, +Plan, -Reachable
          ]).
/** <module> What a session is going to do, settled before anything runs

A plan is a dict with the files of the theory, the program, the names that go
into result.json, and the arguments of the servers.  Names are resolved here, so
that a wrong one is said at once; --instead is told to the theory.
*/

:- use_module('../installation', [installation_names/3, installation_root/1]).
:- use_module(option_rules, [approach_ranges/3]).
:- use_module('../usage_errors', [did_you_mean/3, usage_error/2]).
:- use_module('../../domain/reasoning/instead', [instead_image/2, set_instead/1]).
:- use_module(library(apply), [maplist/3]).
:- use_module(library(lists), [append/3, last/2]).
:- use_module(library(option), [option/2, option/3]).

%!  session_plan(+Options, -Plan) is det.
%
%   @error usage_error(Message)

session_plan(Options, Plan) :-
    installation_root(Root),
    option(controller(Controller), Options),
    controller_file(Root, Controller, ControllerFile, ControllerName),
    model_file(Root, Options, Model),
    check_scenario(Root, Options),
    theory_files(Root, ControllerFile, Files),
    what_it_shows(Options, Shows),
    target_name(Shows, TargetName),
    program(Options, Program),
    option(seed(Seed), Options),
    check_image_of_instead(Options),
    option(instead(Instead), Options, none),
    set_instead(Instead),
    Plan = plan{ root:Root, theory:Files, program:Program, seed:Seed,
                 controller:ControllerName, controller_file:ControllerFile, shows:Shows, target:TargetName,
                 model:Model }.

%   A controller is a name in domain/controllers or a Golog file of the user's.
controller_file(Root, Given, File, Name) :-
    named_file(Root, controller, 'domain/controllers', pl, Given, File),
    base_name(File, Name).

%   The target's model file; none when the image server brings its own.
model_file(Root, Options, File) :-
    option(target(Given), Options),
    !,
    named_file(Root, target, targets, cao, Given, File).
model_file(_, _, none).

%   Scenarios are the image server's to read; a wrong name is said here.
check_scenario(Root, Options) :-
    option(scenario(Given), Options),
    !,
    named_file(Root, scenario, scenarios, toml, Given, _).
check_scenario(_, _).

%   The file that an option names: one of the project's by its name alone, or the user's.
named_file(Root, _, Folder, Extension, Given, File) :-
    atomic_list_concat([Root, /, Folder, /, Given, '.', Extension], File),
    exists_file(File),
    !.
named_file(_, _, _, _, Given, File) :-
    exists_file(Given),
    !,
    absolute_file_name(Given, File).
named_file(_, Option, Folder, Extension, Given, _) :-
    installation_names(Folder, Extension, Names),
    atomic_list_concat(Names, ', ', Known),
    did_you_mean(Given, Names, Hint),
    usage_error("--~w: '~w' is neither a file nor one of ~w.~w", [Option, Given, Known, Hint]).

base_name(File, Name) :-
    file_base_name(File, Base),
    file_name_extension(Name, _, Base).

theory_files(Root, Controller, Files) :-
    maplist(under(Root), ['domain/acquisition.pl', 'domain/procedures.pl', 'domain/approach.pl'], Own),
    append(Own, [Controller], Files).

under(Root, Path, File) :-
    atomic_list_concat([Root, /, Path], File).

%   What is in the images, as far as the command line tells.
what_it_shows(Options, target(Name)) :-
    option(target(Given), Options),
    !,
    base_name(Given, Name).
what_it_shows(Options, stack(Name)) :-
    option(stack(Dir), Options),
    !,
    absolute_file_name(Dir, Absolute),
    file_base_name(Absolute, Name).
what_it_shows(_, served).

%   In the name of the run folder, and in result.json until the image server has told its target.
target_name(target(Name), Name).
target_name(stack(Name), Name).
target_name(served, unknown).

%   An image that a session cannot come to.  How many an approach takes is not known before.
check_image_of_instead(Options) :-
    option(instead(Words), Options),
    instead_image(Words, Number),
    option(max_iterations(Limit), Options),
    ( option(approach(true), Options) -> Last = inf ; Last = Limit ),
    \+ between(1, Last, Number),
    !,
    (   Number < 1
    ->  usage_error("--instead: there is no image i~d; the first one is i1", [Number])
    ;   usage_error("--instead: there is no image i~d; a session takes at most ~d (--max-iterations)", [Number, Limit])
    ).
check_image_of_instead(_).

program(Options, session(Ranges)) :-
    option(approach(true), Options),
    !,
    approach_ranges(Options, First, Contact),
    hold_ranges(First, Contact, Ranges).
program(_, session).

%!  within_reach(+Options, +Device, +Plan, -Reachable) is det.
%
%   The plan with hold points that the target can come to, as Device, an answer of `describe`, tells: farther ones than the
%   defaults for a large target.
%
%   @error usage_error(Message) where those that were asked for are too near

within_reach(Options, Device, Plan, Reachable) :-
    Plan.program = session(Ranges),
    Nearest = Device.get(nearest_m),
    number(Nearest),
    last(Ranges, Contact),
    Contact < Nearest,
    !,
    (   ( option(first_range(_), Options) ; option(contact_range(_), Options) )
    ->  usage_error("--contact-range: the target is so large that it cannot come to ~3g m; ~3g m is the least, and --first-range is more",
                    [Contact, Nearest])
    ;   approach_ranges([], First, Last),
        least_end(Share),
        Near is Share * Nearest,
        Far is First * Near / Last,
        hold_ranges(Far, Near, Fitting),
        Reachable = Plan.put(program, session(Fitting))
    ).
within_reach(_, _, Plan, Plan).

least_end(1.2).                         % of what the target can come to; chosen by hand

%   Hold points from the first to the contact range, each at about three quarters
%   of the one before.

hold_ranges(First, Contact, Ranges) :-
    Steps is max(1, ceiling(log(First / Contact) / log(4 / 3))),
    findall(Range,
            ( between(0, Steps, I),
              Exact is First * (Contact / First) ** (I / Steps),
              Range is round(Exact * 1000) / 1000.0 ),
            Ranges).

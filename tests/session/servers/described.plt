:- module(test_session_described, []).
:- use_module(library(plunit)).
:- use_module(library(lists), [append/3]).
:- use_module(library(filesex), [delete_directory_and_contents/1]).
:- use_module('../../../session/servers/described').
:- use_module('../../../session/device/acquisition_device', []).

/** <module> What an image server describes, and what of it a session that goes on must find again */

lamp(Name, Levels, Place, light{name:Name, levels:Levels, position:Place}).

described(Changes, Description) :-
    lamp("left", 8, [0.1, 0, 0], Left),
    lamp("right", 8, [-0.1, 0, 0], Right),
    Description = description{lights:[Left, Right], shutters_s:[0.01, 0.02], apertures:[4.0], focuses_m:null,
                              camera:camera{fx:800.0, width:640}}.put(Changes).

% changed(-Changes, -Words): what is said where a device is another in this way
changed(_{lights:[Right, Left]}, "lights: right, left; at its beginning left, right") :-
    lamp("left", 8, [0.1, 0, 0], Left),
    lamp("right", 8, [-0.1, 0, 0], Right).
changed(_{lights:[Left, Right]}, "levels of the light left (1): 2; at its beginning 8") :-
    lamp("left", 2, [0.1, 0, 0], Left),
    lamp("right", 8, [-0.1, 0, 0], Right).
changed(_{lights:[Left, Right]}, "position of the light right (2): -0.2, 0, 0; at its beginning -0.1, 0, 0") :-
    lamp("left", 8, [0.1, 0, 0], Left),
    lamp("right", 8, [-0.2, 0, 0], Right).
changed(_{shutters_s:[0.01]}, "shutters_s: 0.01; at its beginning 0.01, 0.02").
changed(_{camera:camera{fx:801.0, width:640}}, "camera fx: 801.0; at its beginning 800.0").

same(_{}).
same(_{camera:camera{fx:800, width:640, bits:8}}).
same(_{events:"ipc://elsewhere"}).

:- dynamic folder/1.

folder_of_a_session :-
    tmp_file(run, Folder),
    make_directory(Folder),
    atom_concat(Folder, '/history.pl', Journal),
    setup_call_cleanup(open(Journal, write, Stream), format(Stream, "begun(session,1).~n", []), close(Stream)),
    assertz(folder(Folder)).

no_folder :-
    retract(folder(Folder)),
    delete_directory_and_contents(Folder).

goes_on(Changes, More) :-
    described(_{}, Was),
    kept_description(Was, Text),
    described(Changes, Is),
    folder(Folder),
    append(More, [described(Text), resume(Folder)], Options),
    check_as_begun(Options, Folder, 1, Is).

:- begin_tests(described, [setup(folder_of_a_session), cleanup(no_folder)]).

test(another_device_is_refused_with_what_differs,
     [forall(changed(Changes, Words)), error(usage_error(_))]) :-
    catch(goes_on(Changes, []), error(usage_error(Message), _),
          ( assertion(sub_string(Message, _, _, 0, Words)), throw(error(usage_error(Message), _)) )).
test(the_same_device_goes_on, [forall(same(Changes))]) :-
    goes_on(Changes, []).
test(a_session_of_an_older_version_goes_on) :-
    described(_{lights:[]}, Is),
    folder(Folder),
    check_as_begun([resume(Folder)], Folder, 1, Is).
test(a_description_need_not_tell_of_a_target, fail) :-
    described(_{}, Description),
    draws(Description, 1, _, _).
test(a_light_fault_without_its_light_is_said, error(server_error(bad_reply, _, _))) :-
    session_acquisition_device:event_action(_{event:"light_fault", args:_{}, sequence:1}, _).

:- end_tests(described).

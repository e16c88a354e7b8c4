:- module(bridge_keys,
          [ client_keys/4               % +Folder, +Name, +Server, -Curve
          ]).
/** <module> CURVE keys of a folder

As `python -m bridge keys DIR` writes them: `NAME.key` has a public key,
`NAME.key_secret` a pair (the certificates of pyzmq and CZMQ).
*/

:- use_module(zmq, [zmq_private_file/1]).
:- use_module(library(lists), [member/2]).
:- use_module(library(readutil), [read_file_to_string/3]).

:- multifile prolog:error_message//1.

prolog:error_message(no_key(File, Which)) -->
    [ 'No ~w key in ~w. Make keys with: python -m bridge keys DIR, and copy DIR to each machine.'-[Which, File] ].

prolog:error_message(open_secret(File)) -->
    [ 'Others can read ~w. It is a secret: chmod 600 ~w'-[File, File] ].

%!  client_keys(+Folder, +Name, +Server, -Curve) is det.
%
%   Curve is curve(PublicKey, SecretKey, ServerKey), as client_open/3 takes it, of the program Name that calls
%   Server.
%
%   @error no_key(File, Which) for a file that is missing or holds no such key
%   @error open_secret(File) for a secret key that others can read

client_keys(Folder, Name, Server, curve(Public, Secret, ServerKey)) :-
    key(Folder, Name, '.key_secret', public, Public),
    key(Folder, Name, '.key_secret', secret, Secret),
    atomic_list_concat([Folder, /, Name, '.key_secret'], File),
    (   zmq_private_file(File)
    ->  true
    ;   throw(error(open_secret(File), _))
    ),
    key(Folder, Server, '.key', public, ServerKey).

key(Folder, Name, Extension, Which, Key) :-
    atomic_list_concat([Folder, /, Name, Extension], File),
    (   catch(read_file_to_string(File, Text, [encoding(utf8)]), error(_, _), fail),
        split_string(Text, "\n", " \t\r", Lines),
        atom_concat(Which, '-key', Label),
        member(Line, Lines),
        split_string(Line, "=", " \t", [Left|_]),
        atom_string(Label, Left),
        sub_string(Line, Before, 1, _, "\""),
        sub_string(Line, _, 1, 0, "\""),
        Start is Before + 1,
        sub_string(Line, Start, 40, 1, Key)
    ->  true
    ;   throw(error(no_key(File, Which), _))
    ).

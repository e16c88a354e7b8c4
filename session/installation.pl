:- module(session_installation,
          [ installation_root/1,        % -Root
            installation_python/1,      % -Python
            installation_names/3,       % +Folder, +Extension, -Names
            installation_version/1,     % -Version
            installed_command/0,
            installation_complete/0
          ]).
/** <module> Where the parts of this installation lie: a checkout that `make setup` has set up, or an installed copy */

:- use_module(library(lists), [member/2]).
:- autoload(library(readutil), [read_file_to_string/3]).

%!  installation_root(-Root) is det.
%
%   The folder of main.pl: a session may be started from any other.

installation_root(Root) :-
    module_property(session_installation, file(File)),
    file_directory_name(File, Session),
    file_directory_name(Session, Root).

%!  installation_python(-Python) is det.
%
%   The Python that runs the servers: the one that the command `lights-and-camera` runs in, or the checkout's own.

installation_python(Python) :-
    getenv('LIGHTS_AND_CAMERA_PYTHON', Python),
    !.
installation_python(Python) :-
    installation_root(Root),
    atom_concat(Root, '/.venv/bin/python', Python).

%!  installation_names(+Folder, +Extension, -Names) is det.
%
%   What comes with it of one kind: the names of such files in this folder of the installation.

installation_names(Folder, Extension, Names) :-
    installation_root(Root),
    atomic_list_concat([Root, /, Folder, '/*.', Extension], Pattern),
    expand_file_name(Pattern, Files),
    findall(Name,
            ( member(File, Files), file_base_name(File, Base), file_name_extension(Name, _, Base) ),
            Names).

%!  installed_command is semidet.
%
%   Whether this is the command `lights-and-camera`.

installed_command :-
    getenv('LIGHTS_AND_CAMERA_PYTHON', _).

%!  installation_version(-Version) is det.
%
%   As bridge/__init__.py says it.

installation_version(Version) :-
    installation_root(Root),
    atom_concat(Root, '/bridge/__init__.py', File),
    read_file_to_string(File, Text, []),
    split_string(Text, "\n", "", Lines),
    member(Line, Lines),
    split_string(Line, "=", " \"", ["__version__", Version]),
    !.

%!  installation_complete is semidet.
%
%   Whether there are that Python and the C module, which cannot be had from the sources alone.

installation_complete :-
    installation_python(Python),
    installation_root(Root),
    atom_concat(Root, '/bridge/prolog/zmq4pl.so', Module),
    forall(member(File, [Python, Module]), exists_file(File)).

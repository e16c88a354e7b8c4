:- module(check_loading,
          [ check_loading/0
          ]).
/** <module> Every Prolog module loads without a warning and calls nothing undefined */

:- use_module(library(check), [list_undefined/1]).
:- use_module(library(filesex), [directory_member/3]).
:- use_module(library(lists), [member/2, memberchk/2]).

:- dynamic complaint/0.

:- multifile user:message_hook/3.

user:message_hook(_, Kind, _) :-
    memberchk(Kind, [error, warning]),
    assertz(complaint),
    fail.                               % still printed

%!  check_loading is semidet.

check_loading :-
    forall(( member(Folder, [indigolog, bridge, domain, session]), module_file(Folder, File) ),
           load_files(File, [if(not_loaded), imports([])])),
    list_undefined([module_class([user])]),
    \+ complaint.

% Theories are plain Prolog without a header and are loaded by load_theory/1; run.pl is a command.
module_file(Folder, File) :-
    module_property(check_loading, file(Here)),
    file_directory_name(Here, Tests),
    atomic_list_concat([Tests, '/../', Folder], Path),
    directory_member(Path, File, [recursive(true), extensions([pl])]),
    file_base_name(File, Base),
    \+ memberchk(Base, ['run.pl', 'pack.pl']),
    is_module(File).

is_module(File) :-
    setup_call_cleanup(open(File, read, Stream),
                       read_term(Stream, Term, []),
                       close(Stream)),
    Term = (:- module(_, _)).

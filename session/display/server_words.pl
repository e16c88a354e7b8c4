:- module(session_server_words,
          [ server_words/2,             % +Server, -Words
            what_happened/2,            % +Error, -What
            what_is_done/2              % +Error, -Done
          ]).
/** <module> What is said of a server that died or did not answer */

:- use_module('../usage_errors', [refused_by_server/1]).

:- multifile prolog:error_message//1.

%!  what_happened(+Error, -What) is det.
%!  what_is_done(+Error, -Done) is det.

what_happened(error(server_died(Name, Status, _, _), _), What) =>
    how_it_ended(Status, How),
    server_words(Name, Words),
    format(string(What), "the ~w ~w", [Words, How]).
what_happened(error(server_error(_, Message, _), _), What) =>
    (   sub_string(Message, Before, 1, 0, ".")
    ->  sub_string(Message, 0, Before, _, What)
    ;   What = Message
    ).

%!  server_words(+Server, -Words) is det.

server_words(image_server, 'image server').
server_words(vision_server, 'vision server').

how_it_ended(exit(Status), How) =>
    format(string(How), "ended by itself, with exit status ~w", [Status]).
how_it_ended(killed(Signal), How) =>
    format(string(How), "was killed, by signal ~w", [Signal]).
how_it_ended(gone, How) =>
    How = "is gone".

what_is_done(error(server_error(timeout, _, _), _), Done) =>
    Done = 'it is waited for and asked again'.
what_is_done(error(server_error(no_session, _, _), _), Done) =>
    Done = 'it is told of the session again'.
what_is_done(_, Done) =>
    Done = 'it is brought back'.

prolog:error_message(server_died(Name, Status, Line, LogFile)) -->
    (   { refused_by_server(server_died(Name, Status, Line, LogFile)) }
    ->  [ '~w'-[Line] ]
    ;   died_words(Status, Name, Line),
        ( { exists_file(LogFile) } -> [ nl, '  its log is ~w'-[LogFile] ] ; [] )   % the folder of a --dry-run is gone
    ).

died_words(Status, Name, Line) -->
    { how_it_ended(Status, How), server_words(Name, Words) },
    [ 'the ~w ~w'-[Words, How] ],
    ( { Line == "" } -> [] ; [ ': ~w'-[Line] ] ).

/** <module> Requests to the servers, and their events

A client sends one request at a time to one server. Each request has a deadline in all; a request without an answer
is sent again, a bounded number of times, on a fresh socket and with the same id, so that a server that has done it
already answers from memory and nothing is done twice. What a request can throw is

    error(server_error(Code, Message, Hint), _)         the server's error reply, or `bad_reply`
    error(bridge_timeout(Endpoint, Op, Seconds), _)     no answer within the deadline
    error(bridge_refused(Endpoint), _)                  it does not let this client in

and whatever the client's `alive` goal throws. JSON objects are dicts; their strings are strings, and `true`, `false`
and `null` are atoms.
*/

:- module(bridge_client,
          [ client_open/3,          % +Endpoint, -Client, :Options
            client_request/5,       % +Client, +Op, +Args, -Result, +Options
            client_close/1,         % +Client
            client_seconds/2        % +Client, -Seconds
          ]).
:- reexport(events).
:- use_module(library(error), [existence_error/2, must_be/2]).
:- use_module(library(option), [meta_options/3, option/3]).
:- use_module(handshake).
:- use_module(json).
:- use_module(slices).
:- use_module(types, [check_result/3]).
:- use_module(zmq).

:- meta_predicate
    client_open(+, -, :).

:- dynamic
    client/2,                       % Client, dict: what it was opened with
    client_socket/2,                % Client, Socket: where it is connected
    client_waited/2.                % Client, Seconds
:- volatile
    client/2,
    client_socket/2,
    client_waited/2.

max_header_characters(1048576).     % of protocol version 1
reconnect_ms(10).                   % between two tries to connect: a server that is starting is there at any moment

:- multifile prolog:error_message//1.

prolog:error_message(bridge_refused(Endpoint)) -->
    [ 'The server at ~w does not let this client in. '-[Endpoint],
      'Has each of the two the key that the other expects (--keys)? Is it a server of this protocol?'
    ].

prolog:error_message(server_error(_Code, Message, Hint)) -->
    [ '~w'-[Message] ],
    (   { Hint == "" ; Hint == '' }
    ->  []
    ;   [ ' ~w'-[Hint] ]
    ).
prolog:error_message(bridge_timeout(Endpoint, Op, Seconds)) -->
    [ 'The server at ~w did not answer "~w" within ~w s. '-[Endpoint, Op, Seconds],
      'Does it run, and listen there?'
    ].
prolog:error_message(bridge_absent(Endpoint, Seconds)) -->
    [ 'Nobody has listened at ~w for ~w s. Is the path right, and does the server run?'-[Endpoint, Seconds] ].

%!  client_open(+Endpoint, -Client, :Options) is det.
%
%   A client of the server at Endpoint. It connects at its first request, and belongs to the thread that makes
%   it. Options:
%
%     - timeout(+Seconds)
%       Deadline of a request in all, retries included; default 10.
%     - retries(+N)
%       How often a request without an answer is sent again; default 2.
%     - alive(:Goal)
%       Called while waiting, at least every 0.1 s. It throws when there is no use in waiting any longer, for
%       example because the server's process is gone; success and failure are the same.
%     - curve(+PublicKey, +SecretKey, +ServerKey)
%       Keys of CURVE.
%     - server(+Name)
%       `image_server` or `vision_server`: its results are of the types of the protocol, or errors (`bad_reply`).

client_open(Endpoint, Client, Options0) :-
    meta_options(is_meta, Options0, Options),
    option(timeout(Timeout), Options, 10),
    option(retries(Retries), Options, 2),
    option(alive(Alive), Options, true),
    must_be(between(0.0, 1.0e9), Timeout),
    must_be(nonneg, Retries),
    option(server(Server), Options, unknown),
    curve_option(Options, Curve),
    flag(bridge_client, N, N+1),
    Client = '$bridge_client'(N),
    client_name(N, Name),
    asserta(client_waited(Client, 0.0)),
    asserta(client(Client, client{endpoint:Endpoint, name:Name, timeout:Timeout, retries:Retries, alive:Alive,
                                  curve:Curve, server:Server})).

is_meta(alive).

%   A server keeps its memory of replies by this name, so no two clients may ever share one. It takes nothing from the
%   random generator, which belongs to the session's seed.

client_name(N, Name) :-
    current_prolog_flag(pid, Pid),
    get_time(Now),
    Microseconds is truncate(Now*1000000),
    format(atom(Name), 'prolog-~d-~d-~d', [Pid, Microseconds, N]).

%!  client_close(+Client) is det.
%
%   Close the connection and forget the client. Closing twice is no error.

client_close(Client) :-
    disconnect(Client),
    retractall(client(Client, _)),
    retractall(client_waited(Client, _)).

%!  client_seconds(+Client, -Seconds) is det.
%
%   Time that was spent waiting for answers since the client was opened.

client_seconds(Client, Seconds) :-
    (   client_waited(Client, Seconds0)
    ->  Seconds = Seconds0
    ;   existence_error(bridge_client, Client)
    ).

%!  client_request(+Client, +Op, +Args, -Result, +Options) is det.
%
%   Do one operation of the server. Args and Result are dicts. Option timeout(Seconds) overrules the client's.

client_request(Client, Op, Args, Result, Options) :-
    (   client(Client, Opened)
    ->  true
    ;   existence_error(bridge_client, Client)
    ),
    option(timeout(Timeout), Options, Opened.timeout),
    flag(Opened.name, N0, N0+1),
    N is N0+1,
    format(string(Id), '~w/~d', [Opened.name, N]),
    json_text(_{v:1, id:Id, op:Op, args:Args}, Text),
    zmq_clock(Start),
    catch(attempts(Client, request(Id, Text), Opened.put(timeout, Timeout), Reply), Error, true),
    zmq_clock(End),
    add_seconds(Client, End-Start),
    (   nonvar(Error)
    ->  disconnect(Client),
        throw(Error)
    ;   Reply == none
    ->  throw(error(bridge_timeout(Opened.endpoint, Op, Timeout), _))
    ;   reply_result(Reply, Client, Opened.endpoint, Result0),
        checked_result(Opened, Op, Client, Result0),
        Result = Result0
    ).

checked_result(Opened, Op, Client, Result) :-
    catch(check_result(Opened.server, Op, Result), misfit(Where, What), true),
    (   var(What)
    ->  true
    ;   ( What = lacking(Key) -> Verb = 'has no' ; Verb = 'should be', Key = What ),
        format(string(Why), "~w ~w ~w", [Where, Verb, Key]),
        bad_reply(Client, Opened.endpoint, Why)
    ).

add_seconds(Client, More) :-
    (   retract(client_waited(Client, S0))
    ->  S is S0+More,
        asserta(client_waited(Client, S))
    ;   true                        % closed meanwhile
    ).

%   Each attempt has an equal share of the time.

attempts(Client, request(Id, Text), Opened, Reply) :-
    _{timeout:Timeout, retries:Retries, alive:Alive} :< Opened,
    Last is Retries+1,
    Share is Timeout/Last,
    (   between(1, Last, _),
        connected(Client, Socket),
        (   in_slices(zmq_send(Socket, [Text]), Alive, Share, Left),
            answer(Socket, Id, Alive, Left, Reply0)
        ->  true
        ;   disconnect(Client),
            (   client_waited(Client, Before),
                Before =:= 0.0,         % it has never answered
                handshake_refused(Opened.endpoint, Opened.curve)
            ->  throw(error(bridge_refused(Opened.endpoint), _))
            ;   fail
            )
        )
    ->  Reply = Reply0
    ;   Reply = none
    ).

answer(Socket, Id, Alive, Seconds, Reply) :-
    in_slices(received(Socket, Header), Alive, Seconds, Left),
    reply_to(Header, Id, Reply0),
    (   Reply0 == another           % an answer to a request that was given up
    ->  answer(Socket, Id, Alive, Left, Reply)
    ;   Reply = Reply0
    ).

connected(Client, Socket) :-
    client_socket(Client, Socket),
    !.
connected(Client, Socket) :-
    client(Client, Opened),
    max_frame_bytes(Max),
    reconnect_ms(Again),
    zmq_socket(dealer, Socket, [maxmsgsize(Max), reconnect_ivl(Again)|Opened.curve]),
    catch(zmq_connect(Socket, Opened.endpoint), Error, ( zmq_close(Socket), throw(Error) )),
    asserta(client_socket(Client, Socket)).

disconnect(Client) :-
    forall(retract(client_socket(Client, Socket)), zmq_close(Socket)).

%!  reply_to(+Header, +Id, -Reply) is det.
%
%   Reply is the dict of an answer to request Id, `another` for one to another request, or bad(Why). An error reply
%   without an id is about a request whose id the server could not read.

reply_to(Header, Id, Reply) :-
    catch(header_dict(Header, Dict), bad(Why), true),
    (   nonvar(Why)
    ->  Reply = bad(Why)
    ;   ( Dict.id == Id ; Dict.id == null, Dict.ok == false )
    ->  Reply = Dict
    ;   Reply = another
    ).

header_dict(Header, Dict) :-
    max_header_characters(Max),
    string_length(Header, Length),
    (   Length > Max
    ->  throw(bad("it has more than 1 MiB"))
    ;   true
    ),
    catch(json_term(Header, Dict), error(syntax_error(json(What)), _),
          ( format(string(Why), 'it is no JSON (~w)', [What]),
            throw(bad(Why))
          )),
    (   is_dict(Dict)
    ->  true
    ;   throw(bad("it is no JSON object"))
    ),
    (   _{v:1, ok:_, id:_} :< Dict
    ->  true
    ;   throw(bad("it has no v, id and ok of protocol version 1"))
    ).

%!  reply_result(+Reply, +Client, +Endpoint, -Result) is det.

reply_result(Reply, _, _, Result), is_dict(Reply), Reply.ok == true, is_dict(Reply.get(result)) =>
    Result = Reply.result.
reply_result(Reply, _, _, _), is_dict(Reply), _{code:Code0, message:Message} :< Reply.get(error) =>
    atom_string(Code, Code0),
    (   get_dict(hint, Reply.error, Hint)
    ->  true
    ;   Hint = ""
    ),
    throw(error(server_error(Code, Message, Hint), _)).
reply_result(Reply, Client, Endpoint, _) =>
    (   Reply = bad(Why)
    ->  true
    ;   Why = "it has neither a result nor an error"
    ),
    bad_reply(Client, Endpoint, Why).

bad_reply(Client, Endpoint, Why) :-
    disconnect(Client),
    format(string(Message), 'The reply of the server at ~w cannot be read: ~w.', [Endpoint, Why]),
    throw(error(server_error(bad_reply, Message, "Use a client and a server of the same release."), _)).

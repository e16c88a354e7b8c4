:- module(session_processes,
          [ start_server/5,             % +Name, +Arguments, +Redirection, +LogFile, -Process
            check_alive/1,              % +Process
            stop_processes/1,           % +Processes
            kill_process/1,             % +Process
            ended_or_killed/3           % +Seconds, +Pid, -Status
          ]).
/** <module> The two servers as child processes

Each runs in a session of its own, so that Ctrl-C reaches only the controller,
which then stops the servers in order.  Should the controller be killed outright
they notice by themselves (`--parent`).
*/

:- use_module('../../bridge/prolog/zmq', [zmq_clock/1]).
:- use_module('../installation', [installation_python/1, installation_root/1]).
:- autoload(library(apply), [exclude/3]).
:- use_module(kept_servers, [kept_log/2, kept_running/2]).
:- use_module(library(lists), [last/2, member/2]).
:- use_module(library(process), [process_create/3, process_kill/2, process_wait/3]).
:- autoload(library(readutil), [read_file_to_string/3]).

%!  start_server(+Name, +Arguments, +Redirection, +LogFile, -Process) is det.
%
%   Run `python -m Name Arguments`, all its output going to LogFile: Redirection is `>` or `>>`.  Process is
%   process(Name, Pid, LogFile).

start_server(Name, Arguments, Redirection, LogFile, process(Name, Pid, LogFile)) :-
    installation_root(Root),
    installation_python(Python),
    % the shell only redirects: exec leaves no process of its own
    format(atom(Command), 'exec "$@" ~w"$LOG" 2>&1 </dev/null', [Redirection]),
    process_create(path(sh), ['-c', Command, sh, Python, '-m', Name|Arguments],
                   [ process(Pid), detached(true), environment(['LOG'=LogFile, 'PYTHONPATH'=Root]) ]).

%!  check_alive(+Process) is det.
%
%   @error server_died(Name, Status, LastLine, LogFile) if the process has ended

check_alive(kept(Name, Pid, Base)) :-
    \+ kept_running(Base, Pid),
    !,
    kept_log(Base, LogFile),
    died(Name, gone, LogFile).
check_alive(process(Name, Pid, LogFile)) :-
    process_wait(Pid, Status, [timeout(0)]),
    Status \== timeout,
    !,
    died(Name, Status, LogFile).
check_alive(_).

died(Name, Status, LogFile) :-
    last_line(LogFile, Line),
    throw(error(server_died(Name, Status, Line, LogFile), _)).

last_line(LogFile, Line) :-
    catch(read_file_to_string(LogFile, Text, []), _, Text = ""),
    split_string(Text, "\n", "\r \t", Lines0),
    exclude(==(""), Lines0, Lines),
    (   last(Lines, Line) -> true ; Line = "" ).

%!  stop_processes(+Processes) is det.
%
%   Ask all with SIGTERM, insist with SIGKILL on those that run two seconds later.
%   A process that has ended already is left in peace.

stop_processes(Processes) :-
    zmq_clock(Now),
    Deadline is Now + 2,
    forall(member(Process, Processes), ask(Process)),
    forall(member(Process, Processes), insist(Process, Deadline)).

ask(process(_, Pid, _)) :-
    catch(process_kill(Pid, term), error(_, _), true).

insist(process(_, Pid, _), Deadline) :-
    zmq_clock(Now),
    catch(ended_or_killed(Deadline - Now, Pid, _), error(_, _), true).

%!  ended_or_killed(+Seconds, +Pid, -Status) is det.
%
%   Status of a process as process_wait/3 tells it, `timeout` for one that still ran after Seconds, an expression, and had
%   to be killed.  A child that has not become a server yet, a copy of this process, loses a SIGTERM: so SIGKILL is not only
%   for those that are stuck.

ended_or_killed(Seconds, Pid, Status) :-
    zmq_clock(Now),
    Deadline is Now + Seconds,
    wait_until(Deadline, Pid, Status),
    (   Status == timeout
    ->  process_kill(Pid, kill),
        process_wait(Pid, _, [])
    ;   true
    ).

%   process_wait/3 itself waits for ever when it is given a time that is not 0 (SWI-Prolog 9.0).
wait_until(Deadline, Pid, Status) :-
    process_wait(Pid, Now, [timeout(0)]),
    zmq_clock(Time),
    (   ( Now \== timeout ; Time >= Deadline )
    ->  Status = Now
    ;   sleep(0.002),
        wait_until(Deadline, Pid, Status)
    ).

%!  kill_process(+Process) is det.
%
%   Process is gone then, and with it what it listened at: another may take its place.

kill_process(process(_, Pid, _)) :-
    catch(ended_or_killed(0, Pid, _), error(_, _), true).
kill_process(kept(_, Pid, Base)) :-
    catch(process_kill(Pid, kill), error(_, _), true),
    zmq_clock(Now),
    most_dying_s(Most),
    Deadline is Now + Most,
    gone_by(Deadline, Base, Pid).

most_dying_s(2).                        % chosen by hand: it takes milliseconds

%   It is no child of this process, which cannot wait for it.
gone_by(Deadline, Base, Pid) :-
    (   kept_running(Base, Pid),
        zmq_clock(Now),
        Now < Deadline
    ->  sleep(0.002),
        gone_by(Deadline, Base, Pid)
    ;   true
    ).

/*  ZeroMQ sockets for SWI-Prolog.

    A socket is a blob that belongs to the Prolog thread that opened it, since libzmq's sockets may be used by one
    thread at a time only. Waiting is done in slices between which Prolog's signals are handled. The context is never
    terminated: the process may end at any time without waiting for anybody, and LINGER is 0.
*/

#include "zmq4pl.h"
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <sys/stat.h>
#include <time.h>

		 /*******************************
		 *	      ERRORS		*
		 *******************************/

/* `EADDRINUSE` for its number; what is libzmq's own begins at ZMQ_HAUSNUMERO and is no errno of the C library. */
static const char *
errno_name(int number, char *unknown, size_t size)
{ const char *known = strerrorname_np(number);

  if ( known )
    return known;
  switch( number )
  { case EFSM:		 return "EFSM";
    case ENOCOMPATPROTO: return "ENOCOMPATPROTO";
    case ETERM:		 return "ETERM";
    case EMTHREAD:	 return "EMTHREAD";
  }
  snprintf(unknown, size, "E%d", number);
  return unknown;
}

/* error(zmq_error(Errno, Message), context(bridge_zmq:Name/Arity, Culprit)) */
int
zmq_failed(const char *name, int arity, term_t culprit)
{ int number = zmq_errno();
  char unknown[32];
  term_t ex, where;

  if ( PL_exception(0) )
    return FALSE;
  return ( (ex=PL_new_term_ref()) &&
	   (where=(culprit ? culprit : PL_new_term_ref())) &&
	   PL_unify_term(ex,
			 PL_FUNCTOR_CHARS, "error", 2,
			   PL_FUNCTOR_CHARS, "zmq_error", 2,
			     PL_CHARS, errno_name(number, unknown, sizeof(unknown)),
			     PL_UTF8_STRING, zmq_strerror(number),
			   PL_FUNCTOR_CHARS, "context", 2,
			     PL_FUNCTOR_CHARS, ":", 2,
			       PL_CHARS, "bridge_zmq",
			       PL_FUNCTOR_CHARS, "/", 2,
				 PL_CHARS, name,
				 PL_INT, arity,
			     PL_TERM, where) &&
	   PL_raise_exception(ex) );
}

		 /*******************************
		 *	   KEYS AND TIME	*
		 *******************************/

static foreign_t
curve_keypair(term_t public_key, term_t secret_key)
{ char public[41], secret[41];

  if ( zmq_curve_keypair(public, secret) != 0 )
    return zmq_failed("zmq_curve_keypair", 2, 0);
  return PL_unify_chars(public_key, PL_STRING, (size_t)-1, public) &&
	 PL_unify_chars(secret_key, PL_STRING, (size_t)-1, secret);
}

/* A clock that nobody sets, for deadlines. */
static foreign_t
clock_seconds(term_t seconds)
{ struct timespec t;

  clock_gettime(CLOCK_MONOTONIC, &t);
  return PL_unify_float(seconds, (double)t.tv_sec + t.tv_nsec/1e9);
}

/* A file that its group and others can neither read nor change nor run. */
static foreign_t
private_file(term_t file)
{ char *name;
  struct stat found;

  if ( !PL_get_file_name(file, &name, 0) || stat(name, &found) != 0 )
    return FALSE;
  return (found.st_mode & (S_IRWXG|S_IRWXO)) == 0;
}

/* Threads inherit what is blocked when they are started. */
static foreign_t
without_stops(term_t goal)
{ sigset_t stops, before;
  int ok;

  sigemptyset(&stops);
  sigaddset(&stops, SIGINT);
  sigaddset(&stops, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &stops, &before);
  ok = PL_call_predicate(NULL, PL_Q_PASS_EXCEPTION, PL_predicate("call", 1, "system"), goal);
  pthread_sigmask(SIG_SETMASK, &before, NULL);
  return ok;
}

install_t
install_zmq4pl(void)
{ install_sockets();
  install_messages();
  PL_register_foreign("zmq_curve_keypair", 2, curve_keypair, 0);
  PL_register_foreign("zmq_clock", 1, clock_seconds, 0);
  PL_register_foreign("zmq_private_file", 1, private_file, 0);
  PL_register_foreign("zmq_without_stops", 1, without_stops, 0);
}

/*  ZeroMQ sockets for SWI-Prolog.

    A socket is a blob that belongs to the Prolog thread that opened it, since libzmq's sockets may be used by one
    thread at a time only. Atom garbage collection runs in a thread of its own, so collecting a socket only queues
    it; its owner closes it at its next call here, or when the thread ends. Waiting is done in slices between which
    Prolog's signals are handled. The context is never terminated: the process may end at any time without waiting
    for anybody, and LINGER is 0.
*/

#include "zmq4pl.h"
#include <stdio.h>
#include <time.h>

		 /*******************************
		 *	      ERRORS		*
		 *******************************/

static const struct { int number; const char *name; } errno_names[] =
{ { EAGAIN, "EAGAIN" }, { EINTR, "EINTR" }, { EINVAL, "EINVAL" }, { EFAULT, "EFAULT" }, { EMFILE, "EMFILE" },
  { ENFILE, "ENFILE" }, { ENOMEM, "ENOMEM" }, { ENODEV, "ENODEV" }, { ENOENT, "ENOENT" }, { EACCES, "EACCES" },
  { EPERM, "EPERM" }, { ENOTSUP, "ENOTSUP" }, { ENOTSOCK, "ENOTSOCK" }, { EADDRINUSE, "EADDRINUSE" },
  { EADDRNOTAVAIL, "EADDRNOTAVAIL" }, { ECONNREFUSED, "ECONNREFUSED" }, { EHOSTUNREACH, "EHOSTUNREACH" },
  { EINPROGRESS, "EINPROGRESS" }, { EMSGSIZE, "EMSGSIZE" }, { ENAMETOOLONG, "ENAMETOOLONG" },
  { ENETDOWN, "ENETDOWN" }, { ENOBUFS, "ENOBUFS" }, { EPROTONOSUPPORT, "EPROTONOSUPPORT" },
  { EAFNOSUPPORT, "EAFNOSUPPORT" }, { ENOTCONN, "ENOTCONN" }, { ETIMEDOUT, "ETIMEDOUT" },
  { ECONNABORTED, "ECONNABORTED" }, { ECONNRESET, "ECONNRESET" }, { EPROTO, "EPROTO" }, { EFSM, "EFSM" },
  { ENOCOMPATPROTO, "ENOCOMPATPROTO" }, { ETERM, "ETERM" }, { EMTHREAD, "EMTHREAD" }, { 0, NULL }
};

/* error(zmq_error(Errno, Message), context(bridge_zmq:Name/Arity, Culprit)) */
int
zmq_failed(const char *name, int arity, term_t culprit)
{ int number = zmq_errno();
  char unknown[32];
  const char *symbol = NULL;
  term_t ex, where;

  for(int i = 0; errno_names[i].name; i++)
  { if ( errno_names[i].number == number )
    { symbol = errno_names[i].name;
      break;
    }
  }
  if ( !symbol )
  { snprintf(unknown, sizeof(unknown), "E%d", number);
    symbol = unknown;
  }
  if ( PL_exception(0) )
    return FALSE;
  return ( (ex=PL_new_term_ref()) &&
	   (where=(culprit ? culprit : PL_new_term_ref())) &&
	   PL_unify_term(ex,
			 PL_FUNCTOR_CHARS, "error", 2,
			   PL_FUNCTOR_CHARS, "zmq_error", 2,
			     PL_CHARS, symbol,
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
		 *	       KEYS		*
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

static foreign_t
library_version(term_t version)
{ int major, minor, patch;
  char text[64];

  zmq_version(&major, &minor, &patch);
  snprintf(text, sizeof(text), "%d.%d.%d", major, minor, patch);
  return PL_unify_chars(version, PL_STRING, (size_t)-1, text);
}

install_t
install_zmq4pl(void)
{ install_sockets();
  install_messages();
  install_json_read();
  install_json_write();
  PL_register_foreign("zmq_curve_keypair", 2, curve_keypair, 0);
  PL_register_foreign("zmq_clock", 1, clock_seconds, 0);
  PL_register_foreign("zmq_version", 1, library_version, 0);
}

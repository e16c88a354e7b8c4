/*  Sockets as blobs, and their options. */

#include "zmq4pl.h"
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <unistd.h>

static atomic_int open_count;

		 /*******************************
		 *	      SOCKETS		*
		 *******************************/

static int
close_handle(zsock *s)
{ void *handle = s->handle;

  if ( !handle )
    return 0;			/* closing twice is no error */
  s->handle = NULL;
  open_count--;
  return zmq_close(handle);	/* LINGER is 0: returns at once */
}

/* Garbage: nobody can use it any more, so the collecting thread may close it; the collector's lock is the memory
   barrier that libzmq asks for when a socket changes threads. */
static int
release_socket(atom_t a)
{ zsock *s = *(zsock **)PL_blob_data(a, NULL, NULL);

  close_handle(s);
  free(s);
  return TRUE;
}

static int
write_socket(IOSTREAM *out, atom_t a, int flags)
{ zsock *s = *(zsock **)PL_blob_data(a, NULL, NULL);

  (void)flags;
  Sfprintf(out, "<zmq_socket>(%p)", (void *)s);
  return TRUE;
}

static PL_blob_t socket_blob =
{ .magic   = PL_BLOB_MAGIC,
  .flags   = 0,			/* the content is the address of the zsock; each socket is a new blob */
  .name    = "zmq_socket",
  .release = release_socket,
  .write   = write_socket
};

static zsock *
socket_of(term_t t)
{ PL_blob_t *type;
  void *data;

  return PL_get_blob(t, &data, NULL, &type) && type == &socket_blob ? *(zsock **)data : NULL;
}

int
get_socket(term_t t, zsock **sp)
{ zsock *s = socket_of(t);

  if ( !s )
    return PL_type_error("zmq_socket", t);
  if ( !s->handle )
    return PL_existence_error("zmq_socket", t);
  if ( s->owner != PL_thread_self() )
    return PL_permission_error("use_in_other_thread", "zmq_socket", t);
  *sp = s;
  return TRUE;
}

static const struct { const char *name; int type; } socket_types[] =
{ { "dealer", ZMQ_DEALER }, { "router", ZMQ_ROUTER }, { "pub", ZMQ_PUB }, { "sub", ZMQ_SUB },
  { "req", ZMQ_REQ }, { "rep", ZMQ_REP }, { "push", ZMQ_PUSH }, { "pull", ZMQ_PULL },
  { "pair", ZMQ_PAIR }, { "xpub", ZMQ_XPUB }, { "xsub", ZMQ_XSUB }, { NULL, 0 }
};

/* The process's context; one does not survive fork(). */
static void *
the_context(void)
{ static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
  static void *context;
  static pid_t context_pid;
  void *c;

  pthread_mutex_lock(&lock);
  if ( (!context || context_pid != getpid()) && (context = zmq_ctx_new()) )
  { zmq_ctx_set(context, ZMQ_BLOCKY, 0);
    context_pid = getpid();
  }
  c = context;
  pthread_mutex_unlock(&lock);
  return c;
}

/* The first socket starts libzmq's threads. They block signals only once they run, and a signal that one of them gets
   before is lost to Prolog, so let them inherit a full mask. */
static void *
quiet_socket(void *context, int kind)
{ sigset_t all, before;
  void *handle;
  int failure;

  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  handle = zmq_socket(context, kind);
  failure = zmq_errno();
  pthread_sigmask(SIG_SETMASK, &before, NULL);
  errno = failure;
  return handle;
}

static foreign_t
open_socket(term_t type, term_t socket)
{ char *name;
  int kind = -1, linger = 0;
  void *context, *handle;
  zsock *s;

  if ( !PL_get_chars(type, &name, CVT_ATOM|CVT_EXCEPTION) )
    return FALSE;
  for(int i = 0; socket_types[i].name; i++)
  { if ( strcmp(socket_types[i].name, name) == 0 )
      kind = socket_types[i].type;
  }
  if ( kind < 0 )
    return PL_domain_error("zmq_socket_type", type);
  if ( !(context = the_context()) || !(handle = quiet_socket(context, kind)) )
    return zmq_failed("zmq_socket", 3, type);
  zmq_setsockopt(handle, ZMQ_LINGER, &linger, sizeof(linger));
  if ( !(s = malloc(sizeof(*s))) )
  { zmq_close(handle);
    return PL_resource_error("memory");
  }
  *s = (zsock){ handle, PL_thread_self() };
  open_count++;
  return PL_unify_blob(socket, &s, sizeof(s), &socket_blob);
}

static foreign_t
close_socket(term_t socket)
{ zsock *s = socket_of(socket);

  if ( !(s && !s->handle) && !get_socket(socket, &s) )
    return FALSE;
  return close_handle(s) == 0 ? TRUE : zmq_failed("zmq_close", 1, 0);
}

static foreign_t
is_socket(term_t t)
{ zsock *s = socket_of(t);

  return s && s->handle;
}

/* For tests: how many sockets are open in this process. */
static foreign_t
open_sockets(term_t count)
{ return PL_unify_integer(count, open_count);
}

		 /*******************************
		 *	      OPTIONS		*
		 *******************************/

typedef enum { INT, INT64, BYTES, KEY } kind;

static const struct { const char *name; int option; kind type; } options[] =
{ { "rcvhwm", ZMQ_RCVHWM, INT }, { "reconnect_ivl", ZMQ_RECONNECT_IVL, INT }, { "maxmsgsize", ZMQ_MAXMSGSIZE, INT64 },
  { "router_mandatory", ZMQ_ROUTER_MANDATORY, INT }, { "xpub_welcome_msg", ZMQ_XPUB_WELCOME_MSG, BYTES },
  { "subscribe", ZMQ_SUBSCRIBE, BYTES }, { "curve_server", ZMQ_CURVE_SERVER, INT },
  { "curve_publickey", ZMQ_CURVE_PUBLICKEY, KEY }, { "curve_secretkey", ZMQ_CURVE_SECRETKEY, KEY },
  { "curve_serverkey", ZMQ_CURVE_SERVERKEY, KEY }, { NULL, 0, INT }
};

#define KEY_CHARACTERS 40	/* of a CURVE key as Z85 text */

static foreign_t
set_option(term_t socket, term_t name, term_t value)
{ zsock *s;
  char *text, *bytes;
  int i, number;
  int64_t large;
  size_t len;
  const void *data = &number;

  if ( !get_socket(socket, &s) || !PL_get_chars(name, &text, CVT_ATOM|CVT_EXCEPTION) )
    return FALSE;
  for(i = 0; options[i].name && strcmp(options[i].name, text) != 0; )
    i++;
  if ( !options[i].name )
    return PL_domain_error("zmq_option", name);
  if ( options[i].type == INT )
  { if ( !PL_get_bool(value, &number) && !PL_get_integer_ex(value, &number) )
      return FALSE;
    len = sizeof(number);
  } else if ( options[i].type == INT64 )
  { if ( !PL_get_int64_ex(value, &large) )
      return FALSE;
    data = &large;
    len = sizeof(large);
  } else
  { if ( !PL_get_nchars(value, &len, &bytes, CVT_ATOM|CVT_STRING|CVT_LIST|CVT_EXCEPTION|REP_UTF8) )
      return FALSE;
    if ( options[i].type == KEY && len != KEY_CHARACTERS )
      return PL_domain_error("z85_key_of_40_characters", name);	/* a key is not for an error message */
    data = bytes;
  }
  return zmq_setsockopt(s->handle, options[i].option, data, len) == 0 ? TRUE : zmq_failed("zmq_set", 3, name);
}

static foreign_t
last_endpoint(term_t socket, term_t endpoint)
{ zsock *s;
  char text[1024];
  size_t len = sizeof(text);

  if ( !get_socket(socket, &s) )
    return FALSE;
  if ( zmq_getsockopt(s->handle, ZMQ_LAST_ENDPOINT, text, &len) != 0 )
    return zmq_failed("zmq_endpoint", 2, 0);
  return PL_unify_chars(endpoint, PL_STRING|REP_UTF8, (size_t)-1, text);
}

typedef int (*attach)(void *handle, const char *endpoint);

/* An IPv6 address has more colons than the one before its port. With the option set names would be looked up as IPv6
   first, and a server on 127.0.0.1 not be found at localhost. */
static int
is_ipv6(const char *endpoint)
{ return strncmp(endpoint, "tcp://", 6) == 0 && strchr(endpoint + 6, ':') != strrchr(endpoint, ':');
}

static int
attached(term_t socket, term_t endpoint, attach how, const char *name)
{ zsock *s;
  char *text;
  int ipv6;

  if ( !get_socket(socket, &s) ||
       !PL_get_chars(endpoint, &text, CVT_ATOM|CVT_STRING|CVT_EXCEPTION|REP_UTF8) )
    return FALSE;
  ipv6 = is_ipv6(text);
  zmq_setsockopt(s->handle, ZMQ_IPV6, &ipv6, sizeof(ipv6));
  return (*how)(s->handle, text) == 0 ? TRUE : zmq_failed(name, 2, endpoint);
}

static foreign_t
bind_socket(term_t socket, term_t endpoint)
{ return attached(socket, endpoint, zmq_bind, "zmq_bind");
}

static foreign_t
connect_socket(term_t socket, term_t endpoint)
{ return attached(socket, endpoint, zmq_connect, "zmq_connect");
}

/* Tell at an inproc endpoint when a socket connects, and how its handshakes end. */
static foreign_t
monitor_socket(term_t socket, term_t endpoint)
{ zsock *s;
  char *text;
  int events = ZMQ_EVENT_CONNECTED | ZMQ_EVENT_HANDSHAKE_SUCCEEDED | ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL |
	       ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL | ZMQ_EVENT_HANDSHAKE_FAILED_AUTH;

  if ( !get_socket(socket, &s) ||
       !PL_get_chars(endpoint, &text, CVT_ATOM|CVT_STRING|CVT_EXCEPTION|REP_UTF8) )
    return FALSE;
  return zmq_socket_monitor(s->handle, text, events) == 0 ? TRUE : zmq_failed("zmq_monitored", 3, endpoint);
}

static foreign_t
unmonitor_socket(term_t socket)
{ zsock *s;

  if ( !get_socket(socket, &s) )
    return FALSE;
  return zmq_socket_monitor(s->handle, NULL, 0) == 0 ? TRUE : zmq_failed("zmq_monitored", 3, 0);
}

void
install_sockets(void)
{ PL_register_foreign("zmq_open_", 2, open_socket, 0);
  PL_register_foreign("zmq_close", 1, close_socket, 0);
  PL_register_foreign("is_zmq_socket", 1, is_socket, 0);
  PL_register_foreign("zmq_open_sockets", 1, open_sockets, 0);
  PL_register_foreign("zmq_set", 3, set_option, 0);
  PL_register_foreign("zmq_endpoint", 2, last_endpoint, 0);
  PL_register_foreign("zmq_bind", 2, bind_socket, 0);
  PL_register_foreign("zmq_connect", 2, connect_socket, 0);
  PL_register_foreign("zmq_monitor_", 2, monitor_socket, 0);
  PL_register_foreign("zmq_unmonitor_", 1, unmonitor_socket, 0);
}

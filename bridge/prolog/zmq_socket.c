/*  Sockets as blobs, and their options. */

#include "zmq4pl.h"
#include <pthread.h>
#include <signal.h>
#include <unistd.h>

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER; /* guards what follows; never held while waiting */
static zsock *sockets;	/* all that are open, or collected */
static void *context;
static pid_t context_pid;
static int any_collected;

		 /*******************************
		 *	      SOCKETS		*
		 *******************************/

static int
release_socket(atom_t a)
{ zsock *s = *(zsock **)PL_blob_data(a, NULL, NULL);

  pthread_mutex_lock(&lock);
  s->collected = any_collected = TRUE;
  pthread_mutex_unlock(&lock);
  return TRUE;
}

static int
compare_sockets(atom_t a, atom_t b)
{ zsock *s = *(zsock **)PL_blob_data(a, NULL, NULL);
  zsock *t = *(zsock **)PL_blob_data(b, NULL, NULL);

  return s < t ? -1 : s > t;
}

static int
write_socket(IOSTREAM *out, atom_t a, int flags)
{ zsock *s = *(zsock **)PL_blob_data(a, NULL, NULL);

  (void)flags;
  Sfprintf(out, "<zmq_socket>(%p)", (void *)s);
  return TRUE;
}

static void
acquire_socket(atom_t a)
{ zsock *s = *(zsock **)PL_blob_data(a, NULL, NULL);

  s->atom = a;
}

static PL_blob_t socket_blob =
{ .magic   = PL_BLOB_MAGIC,
  .flags   = 0,		/* the content is the address of the zsock; each socket is a new blob */
  .name    = "zmq_socket",
  .release = release_socket,
  .compare = compare_sockets,
  .write   = write_socket,
  .acquire = acquire_socket
};

/* Close and free what was collected, and with `all` whatever the calling thread still has open. */
static void
reap(int thread, int all)
{ zsock **link, *mine = NULL, *s;
  int others = FALSE;

  if ( !any_collected && !all )
    return;
  pthread_mutex_lock(&lock);
  for(link = &sockets; (s=*link); )
  { int owned = (s->owner == thread);

    if ( s->collected && (owned || !s->handle) )
    { *link = s->next;
      s->next = mine;
      mine = s;
      continue;
    }
    if ( s->collected )
    { others = TRUE;
    } else if ( all && owned && s->handle )
    { zmq_close(s->handle);	/* LINGER is 0: returns at once */
      s->handle = NULL;
    }
    link = &s->next;
  }
  any_collected = others;
  pthread_mutex_unlock(&lock);
  while( (s=mine) )
  { mine = s->next;
    if ( s->handle )
      zmq_close(s->handle);
    free(s);
  }
}

void
reap_lost(void)
{ reap(PL_thread_self(), FALSE);
}

static void
thread_ends(void *closure)
{ (void)closure;
  reap(PL_thread_self(), TRUE);
}

/* The socket behind a term, provided that it is open and the calling thread's. */
int
get_socket(term_t t, zsock **sp)
{ PL_blob_t *type;
  void *data;
  zsock *s;

  if ( !PL_get_blob(t, &data, NULL, &type) || type != &socket_blob )
    return PL_type_error("zmq_socket", t);
  s = *(zsock **)data;
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

static void *
the_context(void)
{ void *c;

  pthread_mutex_lock(&lock);
  if ( !context || context_pid != getpid() )	/* a context does not survive fork() */
  { if ( (context = zmq_ctx_new()) )
    { zmq_ctx_set(context, ZMQ_BLOCKY, 0);
      context_pid = getpid();
    }
  }
  c = context;
  pthread_mutex_unlock(&lock);
  return c;
}

static foreign_t
open_socket(term_t type, term_t socket)
{ char *name;
  int kind = -1, linger = 0, failure;
  sigset_t all, before;
  void *c;
  zsock *s;

  if ( !PL_get_chars(type, &name, CVT_ATOM|CVT_EXCEPTION) )
    return FALSE;
  for(int i = 0; socket_types[i].name; i++)
  { if ( strcmp(socket_types[i].name, name) == 0 )
      kind = socket_types[i].type;
  }
  if ( kind < 0 )
    return PL_domain_error("zmq_socket_type", type);
  reap_lost();
  if ( !(c = the_context()) )
    return zmq_failed("zmq_socket", 3, type);
  if ( !(s = calloc(1, sizeof(*s))) )
    return PL_resource_error("memory");
  /* The first socket starts libzmq's threads. They block signals only once they run, and a signal that one of
     them gets before is lost to Prolog, so let them inherit a full mask. */
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  s->handle = zmq_socket(c, kind);
  failure = zmq_errno();
  pthread_sigmask(SIG_SETMASK, &before, NULL);
  if ( !s->handle )
  { free(s);
    errno = failure;
    return zmq_failed("zmq_socket", 3, type);
  }
  zmq_setsockopt(s->handle, ZMQ_LINGER, &linger, sizeof(linger));
  s->owner = PL_thread_self();
  pthread_mutex_lock(&lock);
  s->next = sockets;
  sockets = s;
  pthread_mutex_unlock(&lock);
  if ( PL_unify_blob(socket, &s, sizeof(s), &socket_blob) )
    return TRUE;
  if ( !s->atom )		/* no blob was made, so none will be collected */
  { pthread_mutex_lock(&lock);
    s->collected = any_collected = TRUE;
    pthread_mutex_unlock(&lock);
  }
  return FALSE;
}

static foreign_t
close_socket(term_t socket)
{ PL_blob_t *type;
  void *data;
  zsock *s;
  void *handle;

  reap_lost();
  if ( PL_get_blob(socket, &data, NULL, &type) && type == &socket_blob &&
       !(*(zsock **)data)->handle )
    return TRUE;			/* closing twice is no error */
  if ( !get_socket(socket, &s) )
    return FALSE;
  pthread_mutex_lock(&lock);
  handle = s->handle;
  s->handle = NULL;
  pthread_mutex_unlock(&lock);
  if ( zmq_close(handle) != 0 )
    return zmq_failed("zmq_close", 1, 0);
  return TRUE;
}

static foreign_t
is_socket(term_t t)
{ PL_blob_t *type;
  void *data;

  return PL_get_blob(t, &data, NULL, &type) && type == &socket_blob && (*(zsock **)data)->handle != NULL;
}

/* For tests: how many sockets are open in this process. */
static foreign_t
open_sockets(term_t count)
{ int n = 0;

  reap_lost();
  pthread_mutex_lock(&lock);
  for(zsock *s = sockets; s; s = s->next)
    n += (s->handle != NULL);
  pthread_mutex_unlock(&lock);
  return PL_unify_integer(count, n);
}

		 /*******************************
		 *	      OPTIONS		*
		 *******************************/

typedef enum { INT, INT64, BYTES } kind;

static const struct { const char *name; int option; kind type; } options[] =
{ { "linger", ZMQ_LINGER, INT }, { "sndhwm", ZMQ_SNDHWM, INT }, { "rcvhwm", ZMQ_RCVHWM, INT },
  { "maxmsgsize", ZMQ_MAXMSGSIZE, INT64 }, { "routing_id", ZMQ_ROUTING_ID, BYTES },
  { "subscribe", ZMQ_SUBSCRIBE, BYTES }, { "unsubscribe", ZMQ_UNSUBSCRIBE, BYTES },
  { "immediate", ZMQ_IMMEDIATE, INT }, { "ipv6", ZMQ_IPV6, INT }, { "conflate", ZMQ_CONFLATE, INT },
  { "reconnect_ivl", ZMQ_RECONNECT_IVL, INT }, { "handshake_ivl", ZMQ_HANDSHAKE_IVL, INT },
  { "router_mandatory", ZMQ_ROUTER_MANDATORY, INT }, { "xpub_welcome_msg", ZMQ_XPUB_WELCOME_MSG, BYTES },
  { "curve_server", ZMQ_CURVE_SERVER, INT }, { "curve_publickey", ZMQ_CURVE_PUBLICKEY, BYTES },
  { "curve_secretkey", ZMQ_CURVE_SECRETKEY, BYTES }, { "curve_serverkey", ZMQ_CURVE_SERVERKEY, BYTES },
  { "zap_domain", ZMQ_ZAP_DOMAIN, BYTES }, { "last_endpoint", ZMQ_LAST_ENDPOINT, BYTES }, { NULL, 0, INT }
};

static int
find_option(term_t name)
{ char *text;

  if ( !PL_get_chars(name, &text, CVT_ATOM|CVT_EXCEPTION) )
    return -1;
  for(int i = 0; options[i].name; i++)
  { if ( strcmp(options[i].name, text) == 0 )
      return i;
  }
  PL_domain_error("zmq_option", name);
  return -1;
}

static foreign_t
set_option(term_t socket, term_t name, term_t value)
{ zsock *s;
  int i, rc = -1, number, flag;
  int64_t large;
  char *bytes;
  size_t len;

  if ( !get_socket(socket, &s) || (i=find_option(name)) < 0 )
    return FALSE;
  switch(options[i].type)
  { case INT:
      if ( PL_get_bool(value, &flag) )
	number = flag;
      else if ( !PL_get_integer_ex(value, &number) )
	return FALSE;
      rc = zmq_setsockopt(s->handle, options[i].option, &number, sizeof(number));
      break;
    case INT64:
      if ( !PL_get_int64_ex(value, &large) )
	return FALSE;
      rc = zmq_setsockopt(s->handle, options[i].option, &large, sizeof(large));
      break;
    case BYTES:
      if ( !PL_get_nchars(value, &len, &bytes, CVT_ATOM|CVT_STRING|CVT_LIST|CVT_EXCEPTION|REP_UTF8) )
	return FALSE;
      if ( strncmp(options[i].name, "curve_", 6) == 0 && len != 40 )
	return PL_domain_error("z85_key_of_40_characters", name);	/* a key is not for an error message */
      rc = zmq_setsockopt(s->handle, options[i].option, bytes, len);
      break;
  }
  return rc == 0 ? TRUE : zmq_failed("zmq_set", 3, name);
}

static foreign_t
get_option(term_t socket, term_t name, term_t value)
{ zsock *s;
  int i, number;
  int64_t large;
  char bytes[1024];
  size_t len;

  if ( !get_socket(socket, &s) || (i=find_option(name)) < 0 )
    return FALSE;
  switch(options[i].type)
  { case INT:
      len = sizeof(number);
      return zmq_getsockopt(s->handle, options[i].option, &number, &len) == 0
		? PL_unify_integer(value, number) : zmq_failed("zmq_get", 3, name);
    case INT64:
      len = sizeof(large);
      return zmq_getsockopt(s->handle, options[i].option, &large, &len) == 0
		? PL_unify_int64(value, large) : zmq_failed("zmq_get", 3, name);
    default:
      len = sizeof(bytes);
      if ( zmq_getsockopt(s->handle, options[i].option, bytes, &len) != 0 )
	return zmq_failed("zmq_get", 3, name);
      if ( options[i].option == ZMQ_LAST_ENDPOINT && len > 0 )
	len--;				/* counts the final 0 */
      return PL_unify_chars(value, PL_STRING|REP_UTF8, len, bytes);
  }
}

typedef int (*attach)(void *handle, const char *endpoint);

static int
attached(term_t socket, term_t endpoint, attach how, const char *name)
{ zsock *s;
  char *text;

  if ( !get_socket(socket, &s) ||
       !PL_get_chars(endpoint, &text, CVT_ATOM|CVT_STRING|CVT_EXCEPTION|REP_UTF8) )
    return FALSE;
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

static foreign_t
disconnect_socket(term_t socket, term_t endpoint)
{ return attached(socket, endpoint, zmq_disconnect, "zmq_disconnect");
}

void
install_sockets(void)
{ PL_thread_at_exit(thread_ends, NULL, TRUE);
  PL_register_foreign("zmq_open_", 2, open_socket, 0);
  PL_register_foreign("zmq_close", 1, close_socket, 0);
  PL_register_foreign("is_zmq_socket", 1, is_socket, 0);
  PL_register_foreign("zmq_open_sockets", 1, open_sockets, 0);
  PL_register_foreign("zmq_set", 3, set_option, 0);
  PL_register_foreign("zmq_get", 3, get_option, 0);
  PL_register_foreign("zmq_bind", 2, bind_socket, 0);
  PL_register_foreign("zmq_connect", 2, connect_socket, 0);
  PL_register_foreign("zmq_disconnect", 2, disconnect_socket, 0);
}

/*  ZeroMQ sockets for SWI-Prolog.

    A socket is a blob that belongs to the Prolog thread that opened it, since libzmq's sockets may be used by one
    thread at a time only. Atom garbage collection runs in a thread of its own, so collecting a socket only queues
    it; its owner closes it at its next call here, or when the thread ends. Waiting is done in slices between which
    Prolog's signals are handled. The context is never terminated: the process may end at any time without waiting
    for anybody, and LINGER is 0.
*/

#define _GNU_SOURCE
#include <SWI-Prolog.h>
#include <SWI-Stream.h>
#include <ctype.h>
#include <errno.h>
#include <locale.h>
#include <math.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>
#include <zmq.h>

#define SLICE_MS 100	/* longest wait between two looks at Prolog's signals */
#define MAX_FRAMES 64	/* frames of one message */
#define MAX_POLL 64	/* sockets of one poll */
#define FOREVER INT64_MAX

typedef struct zsock
{ void *handle;		/* NULL: closed */
  int owner;		/* Prolog thread */
  int collected;	/* atom is gone; close and free */
  atom_t atom;
  struct zsock *next;
} zsock;

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER; /* guards what follows; never held while waiting */
static zsock *sockets;	/* all that are open, or collected */
static void *context;
static pid_t context_pid;
static int any_collected;

static atom_t ATOM_utf8, ATOM_octet, ATOM_header, ATOM_infinite;

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

/* error(zmq_error(Errno, Message), context(zmq:Name/Arity, Culprit)) */
static int
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
			       PL_CHARS, "zmq",
			       PL_FUNCTOR_CHARS, "/", 2,
				 PL_CHARS, name,
				 PL_INT, arity,
			     PL_TERM, where) &&
	   PL_raise_exception(ex) );
}

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

static void
thread_ends(void *closure)
{ (void)closure;
  reap(PL_thread_self(), TRUE);
}

/* The socket behind a term, provided that it is open and the calling thread's. */
static int
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
  reap(PL_thread_self(), FALSE);
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

  reap(PL_thread_self(), FALSE);
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

  reap(PL_thread_self(), FALSE);
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

		 /*******************************
		 *	      WAITING		*
		 *******************************/

static int64_t
now_ms(void)
{ struct timespec t;

  clock_gettime(CLOCK_MONOTONIC, &t);
  return (int64_t)t.tv_sec*1000 + t.tv_nsec/1000000;
}

/* Seconds, or `infinite`, as a point in time. */
static int
get_deadline(term_t t, int64_t *deadline)
{ double seconds;
  atom_t a;

  if ( PL_get_atom(t, &a) && a == ATOM_infinite )
  { *deadline = FOREVER;
    return TRUE;
  }
  if ( !PL_get_float_ex(t, &seconds) )
    return FALSE;
  if ( isnan(seconds) || seconds < 0 )
    return PL_domain_error("timeout", t);
  *deadline = seconds > 1e9 ? FOREVER : now_ms() + (int64_t)ceil(seconds*1000);
  return TRUE;
}

/* Poll until something is ready (> 0), the deadline has passed (0), or an error or a Prolog exception (-1). */
static int
wait_for(zsock **socks, zmq_pollitem_t *items, int count, int64_t deadline, const char *name, int arity)
{ for(;;)
  { int64_t left = (deadline == FOREVER ? SLICE_MS : deadline - now_ms());
    int rc;

    left = left > SLICE_MS ? SLICE_MS : left < 0 ? 0 : left;
    rc = zmq_poll(items, count, (long)left);
    if ( rc < 0 && zmq_errno() != EINTR )
    { zmq_failed(name, arity, 0);
      return -1;
    }
    if ( PL_handle_signals() < 0 )
      return -1;
    for(int i = 0; i < count; i++)
    { if ( socks[i]->handle != items[i].socket )	/* closed by a signal handler */
      { term_t t = PL_new_term_ref();

	if ( PL_put_atom(t, socks[i]->atom) )
	  PL_existence_error("zmq_socket", t);
	return -1;
      }
    }
    if ( rc > 0 )
      return rc;
    if ( deadline != FOREVER && now_ms() >= deadline )
      return 0;
  }
}

static int
wait_for_one(zsock *s, short events, int64_t deadline, const char *name)
{ zmq_pollitem_t item = { s->handle, 0, events, 0 };

  return wait_for(&s, &item, 1, deadline, name, 3);
}

static foreign_t
poll_sockets(term_t list, term_t ready, term_t timeout)
{ zmq_pollitem_t items[MAX_POLL];
  zsock *socks[MAX_POLL];
  term_t tail = PL_copy_term_ref(list), head = PL_new_term_ref(), out = PL_copy_term_ref(ready);
  int64_t deadline;
  int count = 0;

  reap(PL_thread_self(), FALSE);
  while( PL_get_list_ex(tail, head, tail) )
  { if ( count == MAX_POLL )
      return PL_resource_error("zmq_poll_sockets");
    if ( !get_socket(head, &socks[count]) )
      return FALSE;
    items[count] = (zmq_pollitem_t){ socks[count]->handle, 0, ZMQ_POLLIN, 0 };
    count++;
  }
  if ( !PL_get_nil_ex(tail) || !get_deadline(timeout, &deadline) )
    return FALSE;
  if ( wait_for(socks, items, count, deadline, "zmq_poll", 3) < 0 )
    return FALSE;
  for(int i = 0; i < count; i++)
  { if ( items[i].revents & ZMQ_POLLIN )
    { if ( !PL_unify_list(out, head, out) || !PL_unify_atom(head, socks[i]->atom) )
	return FALSE;
    }
  }
  return PL_unify_nil(out);
}

		 /*******************************
		 *	     MESSAGES		*
		 *******************************/

/* `header` is UTF-8, and of a message that is received only the first frame. */
static int
get_encoding(term_t t, int *rep, int *first_only)
{ atom_t a;

  if ( !PL_get_atom_ex(t, &a) )
    return FALSE;
  *first_only = (a == ATOM_header);
  if ( a == ATOM_utf8 || a == ATOM_header )
    *rep = REP_UTF8;
  else if ( a == ATOM_octet )
    *rep = REP_ISO_LATIN_1;
  else
    return PL_domain_error("zmq_encoding", t);
  return TRUE;
}

static foreign_t
send_frames(term_t socket, term_t frames, term_t timeout, term_t encoding)
{ zsock *s;
  zmq_msg_t messages[MAX_FRAMES];
  term_t tail = PL_copy_term_ref(frames), head = PL_new_term_ref();
  int64_t deadline;
  int count = 0, sent = 0, rep = 0, first_only, rc = FALSE;

  reap(PL_thread_self(), FALSE);
  if ( !get_socket(socket, &s) || !get_deadline(timeout, &deadline) || 
       !get_encoding(encoding, &rep, &first_only) )
    return FALSE;
  while( PL_get_list_ex(tail, head, tail) )
  { char *text;
    size_t len;

    if ( count == MAX_FRAMES )
    { PL_resource_error("zmq_frames");
      goto out;
    }
    if ( !PL_get_nchars(head, &len, &text, CVT_ATOM|CVT_STRING|CVT_LIST|CVT_EXCEPTION|rep) )
      goto out;
    if ( zmq_msg_init_size(&messages[count], len) != 0 )
    { zmq_failed("zmq_send", 3, 0);
      goto out;
    }
    memcpy(zmq_msg_data(&messages[count]), text, len);
    count++;
  }
  if ( !PL_get_nil_ex(tail) )
    goto out;
  if ( count == 0 )
  { PL_domain_error("non_empty_list", frames);
    goto out;
  }
  while( sent < count )
  { int flags = ZMQ_DONTWAIT | (sent+1 < count ? ZMQ_SNDMORE : 0);

    if ( zmq_msg_send(&messages[sent], s->handle, flags) >= 0 )
    { sent++;
    } else if ( zmq_errno() == EAGAIN )
    { if ( wait_for_one(s, ZMQ_POLLOUT, deadline, "zmq_send") <= 0 )
	goto out;
    } else if ( zmq_errno() == EINTR )
    { if ( PL_handle_signals() < 0 || !get_socket(socket, &s) )
	goto out;
    } else
    { zmq_failed("zmq_send", 3, 0);
      goto out;
    }
  }
  rc = TRUE;

out:
  for(int i = sent; i < count; i++)
    zmq_msg_close(&messages[i]);
  return rc;
}

/* RFC 3629: no overlong forms, no surrogates, nothing above U+10FFFF, nothing cut off. */
static int
is_utf8(const unsigned char *p, size_t len)
{ const unsigned char *end = p+len;

  while( p < end )
  { int more, low = 0x80, high = 0xbf;

    if ( *p < 0x80 ) { p++; continue; }
    if ( *p >= 0xc2 && *p <= 0xdf ) more = 1;
    else if ( *p >= 0xe0 && *p <= 0xef ) { more = 2; if ( *p == 0xe0 ) low = 0xa0; if ( *p == 0xed ) high = 0x9f; }
    else if ( *p >= 0xf0 && *p <= 0xf4 ) { more = 3; if ( *p == 0xf0 ) low = 0x90; if ( *p == 0xf4 ) high = 0x8f; }
    else return FALSE;
    if ( end-p <= more )
      return FALSE;
    p++;
    if ( *p < low || *p > high )
      return FALSE;
    for(p++; --more > 0; p++)
    { if ( *p < 0x80 || *p > 0xbf )
	return FALSE;
    }
  }
  return TRUE;
}

#include "json4pl.c"

static foreign_t
receive_frames(term_t socket, term_t frames, term_t timeout, term_t encoding)
{ zsock *s;
  zmq_msg_t messages[MAX_FRAMES];
  term_t tail = PL_copy_term_ref(frames), head = PL_new_term_ref();
  int64_t deadline;
  int count = 0, more = TRUE, too_many = FALSE, rep = 0, first_only = FALSE, rc = FALSE;

  reap(PL_thread_self(), FALSE);
  if ( !get_socket(socket, &s) || !get_deadline(timeout, &deadline) ||
       !get_encoding(encoding, &rep, &first_only) )
    return FALSE;
  while( more )				/* a message arrives whole or not at all */
  { zmq_msg_t *m;

    if ( count == MAX_FRAMES )
    { too_many = TRUE;
      zmq_msg_close(&messages[--count]);
    }
    m = &messages[count++];
    zmq_msg_init(m);
    while( zmq_msg_recv(m, s->handle, ZMQ_DONTWAIT) < 0 )
    { int e = zmq_errno(), ready = 1;

      if ( e == EAGAIN )
	ready = wait_for_one(s, ZMQ_POLLIN, deadline, "zmq_receive");
      else if ( e != EINTR )
      { zmq_failed("zmq_receive", 3, 0);
	goto out;
      } else if ( PL_handle_signals() < 0 || !get_socket(socket, &s) )
	goto out;
      if ( ready <= 0 )
	goto out;
    }
    more = zmq_msg_more(m);
  }
  if ( too_many )
  { PL_resource_error("zmq_frames");
    goto out;
  }
  for(int i = 0; i < (first_only ? 1 : count); i++)
  { size_t len = zmq_msg_size(&messages[i]);
    char *data = zmq_msg_data(&messages[i]);

    if ( rep == REP_UTF8 && !is_utf8((unsigned char *)data, len) )
    { term_t index = PL_new_term_ref();

      if ( PL_put_integer(index, i) )
	PL_domain_error("utf8_frame", index);
      goto out;
    }
    if ( !PL_unify_list_ex(tail, head, tail) || !PL_unify_chars(head, PL_STRING|rep, len, data) )
      goto out;
  }
  rc = PL_unify_nil_ex(tail);

out:
  for(int i = 0; i < count; i++)
    zmq_msg_close(&messages[i]);
  return rc;
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
{ ATOM_utf8     = PL_new_atom("utf8");
  ATOM_octet    = PL_new_atom("octet");
  ATOM_header   = PL_new_atom("header");
  ATOM_infinite = PL_new_atom("infinite");
  PL_thread_at_exit(thread_ends, NULL, TRUE);

  install_json();
  PL_register_foreign("zmq_open_", 2, open_socket, 0);
  PL_register_foreign("zmq_close", 1, close_socket, 0);
  PL_register_foreign("is_zmq_socket", 1, is_socket, 0);
  PL_register_foreign("zmq_open_sockets", 1, open_sockets, 0);
  PL_register_foreign("zmq_set", 3, set_option, 0);
  PL_register_foreign("zmq_get", 3, get_option, 0);
  PL_register_foreign("zmq_bind", 2, bind_socket, 0);
  PL_register_foreign("zmq_connect", 2, connect_socket, 0);
  PL_register_foreign("zmq_disconnect", 2, disconnect_socket, 0);
  PL_register_foreign("zmq_poll", 3, poll_sockets, 0);
  PL_register_foreign("zmq_send", 4, send_frames, 0);
  PL_register_foreign("zmq_receive", 4, receive_frames, 0);
  PL_register_foreign("zmq_curve_keypair", 2, curve_keypair, 0);
  PL_register_foreign("zmq_clock", 1, clock_seconds, 0);
  PL_register_foreign("zmq_version", 1, library_version, 0);
}

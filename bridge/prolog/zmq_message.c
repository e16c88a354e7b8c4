/*  Waiting, sending and receiving. */

#include "zmq4pl.h"
#include <math.h>
#include <time.h>

#define SLICE_MS 100	/* longest wait between two looks at Prolog's signals */
#define MAX_FRAMES 64	/* frames of one message; chosen by hand, the protocol has at most a few */
#define FOREVER INT64_MAX

static atom_t ATOM_utf8, ATOM_octet, ATOM_header, ATOM_infinite;

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

/* Poll until the socket is ready (> 0), the deadline has passed (0), or an error or a Prolog exception (-1). */
static int
wait_for(zsock *s, short events, int64_t deadline, const char *name)
{ zmq_pollitem_t item = { s->handle, 0, events, 0 };

  for(;;)
  { int64_t left = (deadline == FOREVER ? SLICE_MS : deadline - now_ms());
    int rc;

    left = left > SLICE_MS ? SLICE_MS : left < 0 ? 0 : left;
    rc = zmq_poll(&item, 1, (long)left);
    if ( rc < 0 && zmq_errno() != EINTR )
    { zmq_failed(name, 3, 0);
      return -1;
    }
    if ( PL_handle_signals() < 0 )
      return -1;
    if ( s->handle != item.socket )	/* closed by a signal handler */
    { errno = ENOTSOCK;
      zmq_failed(name, 3, 0);
      return -1;
    }
    if ( rc > 0 )
      return rc;
    if ( deadline != FOREVER && now_ms() >= deadline )
      return 0;
  }
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
    { if ( wait_for(s, ZMQ_POLLOUT, deadline, "zmq_send") <= 0 )
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

/* UTF-8 as of RFC 3629: no overlong forms, no surrogates, nothing above U+10FFFF, nothing cut off. */
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

static foreign_t
receive_frames(term_t socket, term_t frames, term_t timeout, term_t encoding)
{ zsock *s;
  zmq_msg_t messages[MAX_FRAMES];
  term_t tail = PL_copy_term_ref(frames), head = PL_new_term_ref();
  int64_t deadline;
  int count = 0, more = TRUE, too_many = FALSE, rep = 0, first_only = FALSE, rc = FALSE;

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
	ready = wait_for(s, ZMQ_POLLIN, deadline, "zmq_receive");
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

void
install_messages(void)
{ ATOM_utf8     = PL_new_atom("utf8");
  ATOM_octet    = PL_new_atom("octet");
  ATOM_header   = PL_new_atom("header");
  ATOM_infinite = PL_new_atom("infinite");
  PL_register_foreign("zmq_send", 4, send_frames, 0);
  PL_register_foreign("zmq_receive", 4, receive_frames, 0);
}

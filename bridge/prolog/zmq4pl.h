/*  What the parts of the module share: sockets and errors. */

#ifndef ZMQ4PL_H
#define ZMQ4PL_H

#define _GNU_SOURCE
#include <SWI-Prolog.h>
#include <SWI-Stream.h>
#include <errno.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <zmq.h>

#pragma GCC visibility push(hidden)	/* shared among these files only */

typedef struct zsock
{ void *handle;		/* NULL: closed */
  int owner;		/* Prolog thread */
  int collected;	/* atom is gone; close and free */
  atom_t atom;
  struct zsock *next;
} zsock;

/* zmq4pl.c: raise error(zmq_error(Errno, Message), context(bridge_zmq:Name/Arity, Culprit)); 0 for no culprit */
int  zmq_failed(const char *name, int arity, term_t culprit);

/* zmq_socket.c: the open socket of the calling thread behind a term, or an exception */
int  get_socket(term_t t, zsock **sp);
/* close what the calling thread lost to atom garbage collection */
void reap_lost(void);

/* zmq_message.c: RFC 3629 */
int  is_utf8(const unsigned char *p, size_t len);

/* json_read.c: how deeply arrays and objects may nest */
#define MAX_DEPTH 512

void install_sockets(void);
void install_messages(void);
void install_json_read(void);
void install_json_write(void);

#pragma GCC visibility pop

#endif

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
} zsock;

/* zmq4pl.c: raise error(zmq_error(Errno, Message), context(bridge_zmq:Name/Arity, Culprit)); 0 for no culprit */
int  zmq_failed(const char *name, int arity, term_t culprit);

/* zmq_socket.c: the open socket of the calling thread behind a term, or an exception */
int  get_socket(term_t t, zsock **sp);

void install_sockets(void);
void install_messages(void);

#pragma GCC visibility pop

#endif

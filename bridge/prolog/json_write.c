/*  Prolog terms to JSON text, as library(http/json) writes dicts.

    Dicts become objects, lists arrays, strings and atoms JSON strings, but for `true`, `false` and `null`.
*/

#include "zmq4pl.h"
#include <math.h>
#include <stdio.h>

static atom_t ATOM_true, ATOM_false, ATOM_null;
static int dict_value_first;	/* how a dict lies in memory: tag, then value and key, or key and value */

typedef struct
{ char *data;
  size_t len, room;
} buffer;

static int
put(buffer *b, const char *bytes, size_t len)
{ if ( b->len + len > b->room )
  { size_t room = 2*(b->room + len);
    char *data = realloc(b->data, room);

    if ( !data )
      return PL_resource_error("memory");
    b->data = data;
    b->room = room;
  }
  memcpy(b->data + b->len, bytes, len);
  b->len += len;
  return TRUE;
}

#define PUT(b, literal) put(b, literal, sizeof(literal)-1)

static int
put_string(buffer *b, const char *s, size_t len)
{ size_t from = 0;

  if ( !PUT(b, "\"") )
    return FALSE;
  for(size_t i = 0; i < len; i++)
  { unsigned char c = (unsigned char)s[i];
    char escape[8];

    if ( c >= 0x20 && c != '"' && c != '\\' )
      continue;
    if ( c == '"' || c == '\\' )
      snprintf(escape, sizeof(escape), "\\%c", c);
    else if ( c == '\n' )
      strcpy(escape, "\\n");
    else
      snprintf(escape, sizeof(escape), "\\u%04x", c);
    if ( !put(b, s+from, i-from) || !put(b, escape, strlen(escape)) )
      return FALSE;
    from = i+1;
  }
  return put(b, s+from, len-from) && PUT(b, "\"");
}

static int
put_text(buffer *b, term_t t)
{ char *s;
  size_t len;
  int rc;

  PL_STRINGS_MARK();
  rc = PL_get_nchars(t, &len, &s, CVT_ATOM|CVT_STRING|CVT_INTEGER|CVT_EXCEPTION|REP_UTF8) &&
       put_string(b, s, len);
  PL_STRINGS_RELEASE();
  return rc;
}

static int
put_number(buffer *b, term_t t)
{ char *s;
  size_t len;
  double value;
  int rc;

  if ( PL_is_float(t) && (!PL_get_float(t, &value) || !isfinite(value)) )
    return PL_domain_error("finite_number", t);
  PL_STRINGS_MARK();
  rc = PL_get_nchars(t, &len, &s, CVT_NUMBER|CVT_EXCEPTION) && put(b, s, len);
  PL_STRINGS_RELEASE();
  return rc;
}

static int put_term(buffer *b, term_t t, int depth);

static int
put_object(buffer *b, term_t t, int depth)
{ atom_t name;
  size_t arity;
  term_t key, value;

  if ( !PL_get_compound_name_arity(t, &name, &arity) || !(key=PL_new_term_ref()) ||
       !(value=PL_new_term_ref()) || !PUT(b, "{") )
    return FALSE;
  for(size_t i = 2; i+1 <= arity; i += 2)
  { if ( !_PL_get_arg(i + (dict_value_first ? 1 : 0), t, key) ||
	 !_PL_get_arg(i + (dict_value_first ? 0 : 1), t, value) ||
	 (i > 2 && !PUT(b, ",")) ||
	 !put_text(b, key) || !PUT(b, ":") || !put_term(b, value, depth+1) )
      return FALSE;
  }
  return PUT(b, "}");
}

static int
put_array(buffer *b, term_t t, int depth)
{ term_t tail = PL_copy_term_ref(t), head = PL_new_term_ref();
  int first = TRUE;

  if ( !head || !PUT(b, "[") )
    return FALSE;
  while( PL_get_list(tail, head, tail) )
  { if ( (!first && !PUT(b, ",")) || !put_term(b, head, depth+1) )
      return FALSE;
    first = FALSE;
  }
  if ( !PL_get_nil(tail) )
    return PL_is_variable(tail) ? PL_instantiation_error(tail) : PL_type_error("list", t);
  return PUT(b, "]");
}

static int
put_term(buffer *b, term_t t, int depth)
{ fid_t frame;
  atom_t a;
  int rc;

  if ( depth > MAX_DEPTH )		/* or cyclic */
    return PL_resource_error("json_depth");
  switch( PL_term_type(t) )
  { case PL_VARIABLE:
      return PL_instantiation_error(t);
    case PL_NIL:
      return PUT(b, "[]");
    case PL_ATOM:
      if ( !PL_get_atom(t, &a) )
	return FALSE;
      if ( a == ATOM_null )
	return PUT(b, "null");
      if ( a == ATOM_true )
	return PUT(b, "true");
      if ( a == ATOM_false )
	return PUT(b, "false");
      return put_text(b, t);
    case PL_STRING:
      return put_text(b, t);
    case PL_INTEGER:
    case PL_FLOAT:
      return put_number(b, t);
    case PL_DICT:
    case PL_LIST_PAIR:
      if ( !(frame=PL_open_foreign_frame()) )
	return FALSE;
      rc = PL_is_dict(t) ? put_object(b, t, depth) : put_array(b, t, depth);
      PL_close_foreign_frame(frame);
      return rc;
    default:
      return PL_type_error("json_term", t);
  }
}

static foreign_t
json_text(term_t term, term_t text)
{ buffer b = { malloc(1024), 0, 1024 };
  int rc;

  if ( !b.data )
    return PL_resource_error("memory");
  rc = put_term(&b, term, 0) && PL_unify_chars(text, PL_STRING|REP_UTF8, b.len, b.data);
  free(b.data);
  return rc;
}

void
install_json_write(void)
{ atom_t key = PL_new_atom("key"), seen;
  term_t dict = PL_new_term_ref(), value = PL_new_term_ref(), arg = PL_new_term_ref();

  ATOM_true  = PL_new_atom("true");
  ATOM_false = PL_new_atom("false");
  ATOM_null  = PL_new_atom("null");
  if ( PL_put_integer(value, 1) && PL_put_dict(dict, 0, 1, &key, value) == TRUE && _PL_get_arg(2, dict, arg) )
    dict_value_first = !(PL_get_atom(arg, &seen) && seen == key);
  PL_register_foreign("json_text", 2, json_text, 0);
}

/*  JSON text to Prolog terms, as library(http/json) reads it with dicts.

    Objects become dicts, arrays lists, JSON strings strings, and `true`, `false` and `null` atoms. The text is strict
    RFC 8259 in UTF-8; a key that comes twice is an error. A first pass checks the text and counts the members of each
    object, a second one builds the term.
*/

#include "zmq4pl.h"
#include <ctype.h>
#include <locale.h>
#include <math.h>

static atom_t ATOM_true, ATOM_false, ATOM_null;
static locale_t json_locale;	/* where a decimal point is a point */

typedef struct
{ const char *start, *p, *end;
  const char *error;	/* what is wrong at p */
  int *members;		/* of each object, in order of their opening braces */
  int objects;		/* opening braces seen so far */
  char *text;		/* room for one string without escapes; as long as the input */
  locale_t c_locale;
} reader;

static int
wrong(reader *r, const char *message)
{ if ( !r->error )
    r->error = message;
  return FALSE;
}

static void
skip_blanks(reader *r)
{ while( r->p < r->end && (*r->p == ' ' || *r->p == '\n' || *r->p == '\r' || *r->p == '\t') )
    r->p++;
}

static int
hex4(reader *r, unsigned *code)
{ *code = 0;
  if ( r->end - r->p < 4 )
    return wrong(r, "cut_off");
  for(int i = 0; i < 4; i++, r->p++)
  { int c = (unsigned char)*r->p;

    if ( !isxdigit(c) )
      return wrong(r, "illegal_escape");
    *code = *code*16 + (unsigned)(c <= '9' ? c-'0' : (c|0x20)-'a'+10);
  }
  return TRUE;
}

static char *
put_utf8(char *out, unsigned c)
{ if ( c < 0x80 )
  { *out++ = (char)c;
  } else if ( c < 0x800 )
  { *out++ = (char)(0xc0|c>>6);
    *out++ = (char)(0x80|(c&0x3f));
  } else if ( c < 0x10000 )
  { *out++ = (char)(0xe0|c>>12);
    *out++ = (char)(0x80|((c>>6)&0x3f));
    *out++ = (char)(0x80|(c&0x3f));
  } else
  { *out++ = (char)(0xf0|c>>18);
    *out++ = (char)(0x80|((c>>12)&0x3f));
    *out++ = (char)(0x80|((c>>6)&0x3f));
    *out++ = (char)(0x80|(c&0x3f));
  }
  return out;
}

/* At the opening quote. An escape is never shorter than what it stands for, so the room suffices. */
static int
read_string(reader *r, size_t *len)
{ char *out = r->text;

  for(r->p++; r->p < r->end; )
  { unsigned char c = (unsigned char)*r->p++;

    if ( c == '"' )
    { *len = (size_t)(out - r->text);
      return TRUE;
    }
    if ( c < 0x20 )
      return wrong(r, "illegal_control_character");
    if ( c != '\\' )
    { *out++ = (char)c;
      continue;
    }
    if ( r->p == r->end )
      break;
    switch( *r->p++ )
    { case '"':  *out++ = '"';  break;
      case '\\': *out++ = '\\'; break;
      case '/':  *out++ = '/';  break;
      case 'b':  *out++ = '\b'; break;
      case 'f':  *out++ = '\f'; break;
      case 'n':  *out++ = '\n'; break;
      case 'r':  *out++ = '\r'; break;
      case 't':  *out++ = '\t'; break;
      case 'u':
      { unsigned code, low;

	if ( !hex4(r, &code) )
	  return FALSE;
	if ( code >= 0xdc00 && code <= 0xdfff )
	  return wrong(r, "lone_surrogate");
	if ( code >= 0xd800 && code <= 0xdbff )
	{ if ( r->end - r->p < 6 || r->p[0] != '\\' || r->p[1] != 'u' )
	    return wrong(r, "lone_surrogate");
	  r->p += 2;
	  if ( !hex4(r, &low) )
	    return FALSE;
	  if ( low < 0xdc00 || low > 0xdfff )
	    return wrong(r, "lone_surrogate");
	  code = 0x10000 + ((code-0xd800)<<10) + (low-0xdc00);
	}
	out = put_utf8(out, code);
	break;
      }
      default:
	return wrong(r, "illegal_escape");
    }
  }
  return wrong(r, "cut_off");
}

/* The grammar of numbers; `integer` when there is neither fraction nor exponent. */
static int
scan_number(reader *r, const char **start, int *integer)
{ const char *p = r->p;

  *start = p;
  *integer = TRUE;
#define DIGIT(q) ((q) < r->end && *(q) >= '0' && *(q) <= '9')
  if ( p < r->end && *p == '-' )
    p++;
  if ( !DIGIT(p) )
    return wrong(r, "illegal_json");
  if ( *p == '0' )
    p++;
  else
    while( DIGIT(p) ) p++;
  if ( p < r->end && *p == '.' )
  { *integer = FALSE;
    if ( !DIGIT(p+1) )
      return wrong(r, "illegal_number");
    for(p++; DIGIT(p); ) p++;
  }
  if ( p < r->end && (*p == 'e' || *p == 'E') )
  { *integer = FALSE;
    p++;
    if ( p < r->end && (*p == '+' || *p == '-') )
      p++;
    if ( !DIGIT(p) )
      return wrong(r, "illegal_number");
    while( DIGIT(p) ) p++;
  }
  r->p = p;
  return TRUE;
}

static int
read_number(reader *r, term_t t)
{ const char *start;
  int integer;

  if ( !scan_number(r, &start, &integer) )
    return FALSE;
  if ( integer && r->p - start <= 18 )
    return PL_put_int64(t, strtoll(start, NULL, 10));
  if ( integer )
    return PL_put_term_from_chars(t, REP_UTF8, (size_t)(r->p - start), start);
  double value = strtod_l(start, NULL, r->c_locale);

  if ( isinf(value) )
    return wrong(r, "number_out_of_range");
  return PL_put_float(t, value);
}

static int
starts_with(reader *r, const char *word)
{ size_t len = strlen(word);

  if ( (size_t)(r->end - r->p) < len || memcmp(r->p, word, len) != 0 )
    return FALSE;
  r->p += len;
  return TRUE;
}

/* First pass: is it JSON, and how many members has each object? */
static int
scan(reader *r, int depth)
{ size_t len;
  const char *start;
  int integer;

  if ( depth > MAX_DEPTH )
    return wrong(r, "nested_too_deeply");
  skip_blanks(r);
  if ( r->p == r->end )
    return wrong(r, "cut_off");
  switch( *r->p )
  { case '{':
    { int me = r->objects++, count = 0;

      r->p++;
      skip_blanks(r);
      if ( r->p < r->end && *r->p == '}' )
      { r->p++;
	r->members[me] = 0;
	return TRUE;
      }
      for(;;)
      { skip_blanks(r);
	if ( r->p == r->end || *r->p != '"' )
	  return wrong(r, r->p == r->end ? "cut_off" : "key_expected");
	if ( !read_string(r, &len) )
	  return FALSE;
	skip_blanks(r);
	if ( r->p == r->end || *r->p != ':' )
	  return wrong(r, "colon_expected");
	r->p++;
	if ( !scan(r, depth+1) )
	  return FALSE;
	count++;
	skip_blanks(r);
	if ( r->p == r->end )
	  return wrong(r, "cut_off");
	if ( *r->p == '}' )
	{ r->p++;
	  r->members[me] = count;
	  return TRUE;
	}
	if ( *r->p != ',' )
	  return wrong(r, "comma_expected");
	r->p++;
      }
    }
    case '[':
      r->p++;
      skip_blanks(r);
      if ( r->p < r->end && *r->p == ']' )
      { r->p++;
	return TRUE;
      }
      for(;;)
      { if ( !scan(r, depth+1) )
	  return FALSE;
	skip_blanks(r);
	if ( r->p == r->end )
	  return wrong(r, "cut_off");
	if ( *r->p == ']' )
	{ r->p++;
	  return TRUE;
	}
	if ( *r->p != ',' )
	  return wrong(r, "comma_expected");
	r->p++;
      }
    case '"':
      return read_string(r, &len);
    case 't':
      return starts_with(r, "true") || wrong(r, "illegal_json");
    case 'f':
      return starts_with(r, "false") || wrong(r, "illegal_json");
    case 'n':
      return starts_with(r, "null") || wrong(r, "illegal_json");
    default:
      return scan_number(r, &start, &integer);
  }
}

static int build(reader *r, term_t t);

static int
twice(atom_t *keys, int count)
{ for(int i = 1; i < count; i++)
  { for(int k = 0; k < i; k++)
    { if ( keys[i] == keys[k] )
	return TRUE;
    }
  }
  return FALSE;
}

static int
build_object(reader *r, term_t t)
{ int count = r->members[r->objects++], i = 0, rc = FALSE;
  fid_t frame = PL_open_foreign_frame();
  atom_t *keys = malloc((size_t)(count+1) * sizeof(*keys));
  term_t values = PL_new_term_refs(count);
  size_t len;

  if ( !keys )
  { PL_resource_error("memory");
    goto out;
  }
  if ( !frame || (count && !values) )
    goto out;
  for(r->p++; i < count; i++)
  { skip_blanks(r);			/* at a quote, after '{' or ',' */
    if ( !read_string(r, &len) )
      goto out;
    if ( !(keys[i]=PL_new_atom_mbchars(REP_UTF8, len, r->text)) )
      goto out;
    skip_blanks(r);
    r->p++;				/* ':' */
    if ( !build(r, values+i) )
    { i++;
      goto out;
    }
    skip_blanks(r);
    r->p++;				/* ',' or '}' */
  }
  if ( count == 0 )
  { skip_blanks(r);
    r->p++;
  }
  rc = (PL_put_dict(t, 0, (size_t)count, keys, values) == TRUE);
  if ( !rc && twice(keys, count) )
  { PL_clear_exception();
    wrong(r, "duplicate_key");
  }

out:
  for(int k = 0; k < i; k++)
    PL_unregister_atom(keys[k]);
  free(keys);
  if ( frame )
    PL_close_foreign_frame(frame);
  return rc;
}

static int
build_array(reader *r, term_t t)
{ fid_t frame = PL_open_foreign_frame();
  term_t tail = PL_new_term_ref(), head = PL_new_term_ref(), item = PL_new_term_ref();
  int rc = FALSE;

  if ( !frame || !item || !PL_put_variable(t) || !PL_put_term(tail, t) )
    goto out;
  r->p++;
  skip_blanks(r);
  if ( *r->p == ']' )
  { r->p++;
  } else
  { for(;;)
    { if ( !build(r, item) || !PL_unify_list(tail, head, tail) || !PL_unify(head, item) )
	goto out;
      skip_blanks(r);
      if ( *r->p++ == ']' )
	break;
    }
  }
  rc = PL_unify_nil(tail);

out:
  if ( frame )
    PL_close_foreign_frame(frame);
  return rc;
}

/* Second pass: the text is known to be JSON. */
static int
build(reader *r, term_t t)
{ size_t len;

  skip_blanks(r);
  switch( *r->p )
  { case '{':
      return build_object(r, t);
    case '[':
      return build_array(r, t);
    case '"':
      return read_string(r, &len) && PL_put_chars(t, PL_STRING|REP_UTF8, len, r->text);
    case 't':
      r->p += 4;
      return PL_put_atom(t, ATOM_true);
    case 'f':
      r->p += 5;
      return PL_put_atom(t, ATOM_false);
    case 'n':
      r->p += 4;
      return PL_put_atom(t, ATOM_null);
    default:
      return read_number(r, t);
  }
}

/* error(syntax_error(json(What)), context(bridge_zmq:json_term/2, byte(Offset))) */
static int
json_failed(reader *r)
{ term_t ex = PL_new_term_ref();

  return !PL_exception(0) && ex &&
	 PL_unify_term(ex,
		       PL_FUNCTOR_CHARS, "error", 2,
			 PL_FUNCTOR_CHARS, "syntax_error", 1,
			   PL_FUNCTOR_CHARS, "json", 1,
			     PL_CHARS, r->error,
			 PL_FUNCTOR_CHARS, "context", 2,
			   PL_FUNCTOR_CHARS, ":", 2,
			     PL_CHARS, "bridge_zmq",
			     PL_FUNCTOR_CHARS, "/", 2,
			       PL_CHARS, "json_term",
			       PL_INT, 2,
			   PL_FUNCTOR_CHARS, "byte", 1,
			     PL_INT64, (int64_t)(r->p - r->start)) &&
	 PL_raise_exception(ex);
}

static foreign_t
json_term(term_t text, term_t term)
{ reader r = { 0 };
  char *bytes;
  size_t len, braces = 0;
  term_t result = PL_new_term_ref();
  int rc = FALSE;

  if ( !PL_get_nchars(text, &len, &bytes, CVT_STRING|CVT_ATOM|CVT_LIST|CVT_EXCEPTION|BUF_MALLOC|REP_UTF8) )
    return FALSE;
  for(size_t i = 0; i < len; i++)
    braces += (bytes[i] == '{');
  r.start = r.p = bytes;
  r.end = bytes+len;
  r.text = malloc(len+4);
  r.members = malloc((braces+1) * sizeof(int));
  r.c_locale = json_locale;
  if ( !r.text || !r.members )
  { PL_resource_error("memory");
    goto out;
  }
  if ( !is_utf8((unsigned char *)bytes, len) )
    wrong(&r, "illegal_utf8");
  else if ( scan(&r, 0) )
  { skip_blanks(&r);
    if ( r.p < r.end )
    { wrong(&r, "end_of_text_expected");
    } else
    { r.p = r.start;
      r.objects = 0;
      rc = build(&r, result) && PL_unify(term, result);
    }
  }
  if ( !rc && r.error )
    json_failed(&r);

out:
  free(r.members);
  free(r.text);
  PL_free(bytes);
  return rc;
}

void
install_json_read(void)
{ ATOM_true   = PL_new_atom("true");
  ATOM_false  = PL_new_atom("false");
  ATOM_null   = PL_new_atom("null");
  json_locale = newlocale(LC_ALL_MASK, "C", (locale_t)0);
  PL_register_foreign("json_term", 2, json_term, 0);
}

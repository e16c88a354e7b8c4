/*  JSON text to Prolog terms and back, as library(http/json) does it with dicts; part of zmq4pl.c.

    Objects are dicts, arrays lists, JSON strings strings; `true`, `false` and `null` are atoms. On the way out atoms and
    strings are the same. The text is strict RFC 8259 in UTF-8; a key that comes twice is an error.
*/

#define MAX_DEPTH 512	/* of nested arrays and objects */

static atom_t ATOM_true, ATOM_false, ATOM_null;
static locale_t json_locale;	/* where a decimal point is a point */
static int dict_value_first;	/* how a dict lies in memory: tag, then value and key, or key and value */

		 /*******************************
		 *	      READING		*
		 *******************************/

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

/* error(syntax_error(json(What)), context(zmq:json_term/2, byte(Offset))) */
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
			     PL_CHARS, "zmq",
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

		 /*******************************
		 *	      WRITING		*
		 *******************************/

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

static void
install_json(void)
{ atom_t key = PL_new_atom("key");
  term_t dict = PL_new_term_ref(), value = PL_new_term_ref(), arg = PL_new_term_ref();
  atom_t seen;

  ATOM_true  = PL_new_atom("true");
  ATOM_false = PL_new_atom("false");
  ATOM_null  = PL_new_atom("null");
  json_locale = newlocale(LC_ALL_MASK, "C", (locale_t)0);
  if ( PL_put_integer(value, 1) && PL_put_dict(dict, 0, 1, &key, value) == TRUE && _PL_get_arg(2, dict, arg) )
    dict_value_first = !(PL_get_atom(arg, &seen) && seen == key);
  PL_register_foreign("json_term", 2, json_term, 0);
  PL_register_foreign("json_text", 2, json_text, 0);
}

/** <module> JSON of a message's header

What library(http/json) reads and writes, with the whole text as one value and one error for all that can be wrong with
it. Objects are dicts, JSON strings are strings, `true`, `false` and `null` are atoms; an atom is written as a string.
The library is lenient: it also takes comments, and control characters in strings.
*/

:- module(bridge_json,
          [ json_term/2,            % +Text, -Term
            json_text/2             % +Term, -Text
          ]).
:- use_module(library(http/json), [json_read_dict/2, json_write_dict/3]).

%!  json_term(+Text, -Term) is det.
%
%   @error syntax_error(json(What)) for a text that is not one JSON value, or none that fits into memory

json_term(Text, Term) :-
    catch(setup_call_cleanup(open_string(Text, In), value(In, Value), close(In)),
          error(Formal, _),
          ( what(Formal, What),
            throw(error(syntax_error(json(What)), _))
          )),
    Term = Value.

value(In, Value) :-
    json_read_dict(In, Value),
    read_string(In, _, Rest),
    (   split_string(Rest, "", " \t\r\n", [""])
    ->  true
    ;   throw(error(end_of_text_expected, _))
    ).

what(syntax_error(json(What)), What) :-
    !.
what(syntax_error(What), What) :-
    !.
what(What, What).

%!  json_text(+Term, -Text) is det.
%
%   Text is one line.
%
%   @error type_error(json_term, Term)

json_text(Term, Text) :-
    with_output_to(string(Text), json_write_dict(current_output, Term, [width(0)])).

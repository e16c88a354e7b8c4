:- module(domain_image_set,
          [ image_name/2,               % +Taken, -Image
            image_names/3,              % +Candidate, +ImageSet, -Images
            kept_states/2               % +ImageSet, -States
          ]).
/** <module> Images of a set and their names

An image set is a list of kept(Image, State), newest first.
*/

:- use_module(library(apply), [maplist/3]).
:- use_module(library(lists), [member/2, reverse/2]).

%!  image_name(+Taken, -Image) is det.
%
%   The name of the next image when Taken have been taken: i1, i2, ...

image_name(Taken, Image) :-
    Number is Taken + 1,
    atom_concat(i, Number, Image).

%!  image_names(+Candidate, +ImageSet, -Images) is det.
%
%   The images of the set and then the candidate, if there is one, oldest first.

image_names(Candidate, ImageSet, Images) :-
    findall(Image, kept_image(ImageSet, Image), Newest),
    (   Candidate == none
    ->  reverse(Newest, Images)
    ;   reverse([Candidate|Newest], Images)
    ).

kept_image(ImageSet, Image) :-
    member(kept(Image, _), ImageSet).

%!  kept_states(+ImageSet, -States) is det.

kept_states(ImageSet, States) :-
    maplist(kept_state, ImageSet, States).

kept_state(kept(_, State), State).

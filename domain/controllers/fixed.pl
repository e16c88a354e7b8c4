% A camera left alone: one image, all lights half way up, the reference exposure.

proc(control, [choose_reference, take_image, measure, keep_image]).

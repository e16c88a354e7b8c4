"""One image: its noise, blur, light, and the gradients that stand out of them.

`channel` puts together what one image says about edges: `noise`, `blur`, how lit it is (`lighting`), and the
pixels whose gradient stands out (`gradient_pixels`, `narrow_gradient`; `gaussian` has the filter).
`gradients` is what refinement asks for, at the scale of each line (`bands`: of a large image never all at
once).

`image_files`, `colours`, `depth`, `tone` and `overexposure` are what is between a file and linear
intensities.
"""

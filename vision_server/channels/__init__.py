"""One image: its noise, blur, light, and the gradients that stand out of them."""

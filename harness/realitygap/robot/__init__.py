"""The robot as every engine gets it: drives, plant and the effects that change them."""

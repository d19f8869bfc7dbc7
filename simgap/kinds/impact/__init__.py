"""Impact events: a rigid impact law against states before and after, and impulses read off them."""

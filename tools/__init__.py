"""Programs for work on the repository; nothing in the packages imports them."""

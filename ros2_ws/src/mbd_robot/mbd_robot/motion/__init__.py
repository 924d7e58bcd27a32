"""Ways of the arm: straight ones of the tool and swings of the joints, timed, clear of table and objects."""

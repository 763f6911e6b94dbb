"""What a person starts: the command line. It stands above all packages; nothing imports it."""

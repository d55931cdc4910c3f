"""Studies: what runs a scene many times. pebble-study starts them; each is a file here."""

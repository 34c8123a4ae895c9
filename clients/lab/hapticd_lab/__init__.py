"""What hapticd-lab is made of: sessions with a real hapticd in lockstep, what is measured of them, and reports of it. Numbers are SI, W the
world, wrenches those on the hand; units other than SI are in the name."""

"""The Human: anatomy, anthropometry, feet, joint sets, markers."""

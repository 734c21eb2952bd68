"""What a scene's runs are compared with (closed forms, proofs, our engine), and until when."""

"""What every test needs."""

import signal

# A shell that starts something in the background without job control has it ignore interrupts, and
# all its children inherit that: tests that press Ctrl-C would wait for ever.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

"""Engines in JavaScript, played by node: planck.js, matter.js, p2.js, cannon-es and Rapier's build.

`driver/` holds what node runs: `serve.mjs` answers, `play.mjs` plays a scene, and each engine is a
short file. `make peers-js` installs the engines by the lock file that lies there.
"""

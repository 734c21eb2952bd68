"""JavaScript engines that run in Node.js: planck.js, matter.js and cannon-es.

The folder `driver/` contains the code for Node.js: `serve.mjs` answers requests, `play.mjs`
simulates a scene, and each engine has a short file. `make peers-js` installs the engines with the
lock file in that folder.
"""

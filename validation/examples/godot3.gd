# Simulate elastic scenes from `ghostball scenes --export` with Godot 3; `ghostball grade` judges the
# results. The issues 29639, 52550 and 38732 of godotengine/godot report such shots: balls with
# bounce 1 gain energy.
#
#     ghostball scenes godot-29639 --export scenes
#     GHOSTBALL_SCENES="scenes/godot-29639.json" GHOSTBALL_RUNS=runs.jsonl \
#         godot3-server --script godot3.gd --fixed-fps 60
#     ghostball grade runs.jsonl
#
# With --fixed-fps 60 a time step is 1/60 s, and Godot doesn't wait for real time. GHOSTBALL_FPS=60
# tells this script the same rate (default: 60). For Godot 4, use godot4.gd.

extends SceneTree

const UNITS = 1000.0 # pixels in a metre
const NORMALS = {"left": Vector2(1, 0), "right": Vector2(-1, 0), "bottom": Vector2(0, 1), "top": Vector2(0, -1)}

var dt = 1.0 / 60.0
var files = []
var text = ""
var shot = null
var world = null
var bodies = []
var step = 0
var events = []
var samples = {}
var out = File.new()


func _initialize():
	var fps = OS.get_environment("GHOSTBALL_FPS")
	dt = 1.0 / (int(fps) if fps else 60)
	Engine.iterations_per_second = int(round(1.0 / dt))
	files = OS.get_environment("GHOSTBALL_SCENES").split(" ", false)
	if files.empty() or out.open(OS.get_environment("GHOSTBALL_RUNS"), File.WRITE) != OK:
		printerr("Set GHOSTBALL_SCENES to files of scenes, and GHOSTBALL_RUNS to a file that can be written")
		files = []


func _iteration(_delta):
	if shot == null:
		if len(files) == 0:
			out.close()
			quit()
			return false
		begin(files[0])
		files.remove(0)
		return false
	sample()
	if step * dt >= shot.t_max * (1.0 - 1e-9):
		finish()
	step += 1
	return false


func begin(path):
	var file = File.new()
	file.open(path, File.READ)
	text = file.get_as_text().replace("\n", "")
	shot = JSON.parse(text).result
	var physics = shot.physics
	var rubs = typeof(physics.ball_friction) == TYPE_STRING or physics.ball_friction != 0
	var elastic = physics.ball_restitution == 1 and physics.cushion == "mirror" and not rubs
	if not elastic or physics.rolling_friction != 0 or physics.motion != "rolling" or shot.t_max == null:
		printerr(path, ": left out, for its balls are slowed, or its impacts aren't elastic")
		shot = null
		return
	step = 0
	events = []
	samples = {"t": [], "positions": [], "velocities": [], "angular_velocities": []}
	bodies = []
	world = Node2D.new()
	get_root().add_child(world)
	Physics2DServer.area_set_param(world.get_world_2d().space, Physics2DServer.AREA_PARAM_GRAVITY, 0)
	var bouncy = PhysicsMaterial.new()
	bouncy.bounce = 1.0
	bouncy.friction = 0.0
	for i in range(len(shot.balls)):
		var ball = shot.balls[i]
		var shape = CircleShape2D.new()
		shape.radius = UNITS * ball.radius
		var body = RigidBody2D.new()
		body.mode = RigidBody2D.MODE_CHARACTER # doesn't turn
		body.physics_material_override = bouncy
		body.linear_damp = -1 # the damping of the project, which is set to 0 below
		body.mass = ball.mass
		body.can_sleep = false
		body.position = UNITS * Vector2(ball.position[0], ball.position[1])
		body.linear_velocity = UNITS * Vector2(ball.velocity[0], ball.velocity[1])
		add(body, shape, i)
		body.contact_monitor = true
		body.contacts_reported = 8
		body.connect("body_entered", self, "collided", [i])
		bodies.append(body)
	Physics2DServer.area_set_param(world.get_world_2d().space, Physics2DServer.AREA_PARAM_LINEAR_DAMP, 0)
	Physics2DServer.area_set_param(world.get_world_2d().space, Physics2DServer.AREA_PARAM_ANGULAR_DAMP, 0)
	for name in shot.table.cushions if shot.table else []:
		var shape = LineShape2D.new()
		shape.normal = NORMALS[name]
		var corner = Vector2(shot.table.length if name == "right" else 0.0, shot.table.width if name == "top" else 0.0)
		shape.d = UNITS * corner.dot(shape.normal)
		var body = StaticBody2D.new()
		body.physics_material_override = bouncy
		add(body, shape, name)


func add(body, shape, index):
	var collision = CollisionShape2D.new()
	collision.shape = shape
	body.add_child(collision)
	body.set_meta("index", index)
	world.add_child(body)


func collided(other, a):
	var b = other.get_meta("index")
	if typeof(b) == TYPE_STRING:
		events.append({"t": step * dt, "kind": "ball-cushion", "a": a, "b": b})
	elif a < b: # both balls get the signal
		events.append({"t": step * dt, "kind": "ball-ball", "a": a, "b": b})


func sample():
	var positions = []
	var velocities = []
	var spins = []
	for i in range(len(bodies)):
		var radius = shot.balls[i].radius
		var x = bodies[i].position / UNITS
		var v = bodies[i].linear_velocity / UNITS
		positions.append([x.x, x.y, radius])
		velocities.append([v.x, v.y, 0.0])
		spins.append([-v.y / radius, v.x / radius, 0.0])
	samples.t.append(step * dt)
	samples.positions.append(positions)
	samples.velocities.append(velocities)
	samples.angular_velocities.append(spins)


func finish():
	# The text of the scene as it was read, because Godot prints fewer digits.
	out.store_line("{\"scene\": %s, %s" % [text, JSON.print({
		"engine": "godot",
		"version": Engine.get_version_info().string,
		"settings": {"dt": dt, "units": UNITS},
		"status": "t-max",
		"rest_time": step * dt,
		"rest_positions": samples.positions[-1],
		"events": events,
		"samples": samples,
		"approximate": {"pure rolling": "in steps, in single precision"},
	}, "", true).substr(1)])
	world.queue_free()
	shot = null

"""The bugs that are planted in copies of our packages, and what catches each.

Each is one text of one file, such as an engine might really have, and most are small: what they
leave wrong is a part in a billion, or shows in one kind of shot alone. It is caught by
a trial of the stress suite, as FAMILY/TRIAL, or by a fast test.
"""

from __future__ import annotations

from typing import Final

from mutants import Mutation

MUTATIONS: Final[tuple[Mutation, ...]] = (
    # When things happen.
    Mutation(
        "dropped root",
        "motion/crossings.py",
        "(discriminant >= 0.0) & (closing | (acceleration < 0.0))",
        "(discriminant >= 0.0) & closing",
        "A gap that opens at first, and is pulled closed later, is never seen to close.",
        "touching/line-of-5-sliding-gap-0",
    ),
    Mutation(
        "naive root",
        "motion/crossings.py",
        "    s = over / (under if meets else 1.0)\n    return s if meets else math.inf\n\n\n"
        "@kernel\ndef first_bent_crossing",
        "    s = over / (under if meets else 1.0)\n    if meets and acceleration != 0.0:\n"
        "        s = -(rate + root) / acceleration\n"
        "    return s if meets else math.inf\n\n\n"
        "@kernel\ndef first_bent_crossing",
        "The quadratic is solved by the formula of the schoolbook, which cancels digits.",
        "extremes/speed-rolling-1e+04",
    ),
    Mutation(
        "late contact",
        "scheduling/all_pairs.py",
        "        bound = t + first_crossing(gap, rate, pull)\n",
        "        bound = t + first_crossing(gap, rate, pull) + 1e-9\n",
        "Two balls on the cloth collide a nanosecond late.",
        "graded/head-on",
    ),
    Mutation(
        "late cushion",
        "motion/next_piece.py",
        "    balls.state[i].own_time = balls.state[i].epoch + duration\n",
        "    late = 1e-9 if balls.own_kind[i] >= st.OWN_CUSHION else 0.0\n"
        "    balls.state[i].own_time = balls.state[i].epoch + duration + late\n",
        "A ball meets a cushion a nanosecond late.",
        "graded/wall-bounce",
    ),
    Mutation(
        "late roll",
        "motion/next_piece.py",
        "    duration: float = size / (3.5 * friction) if friction > 0.0 else math.inf",
        "    duration: float = (1.0 + 1e-9) * size / (3.5 * friction) if friction > 0.0 "
        "else math.inf",
        "A slide turns into rolling late, by a part in a billion.",
        "graded/sliding-swerve",
    ),
    Mutation(
        "stale prediction",
        "scheduling/all_pairs.py",
        "        _update_ball(world, world.contacts, balls.touched[1 + m], t)\n",
        "        if m == 0 or t == 0.0:\n"
        "            _update_ball(world, world.contacts, balls.touched[1 + m], t)\n",
        "The second ball of an impact keeps the predictions of before.",
        "graded/three-ball-chain",
    ),
    Mutation(
        "stale slot",
        "scheduling/broad_phase.py",
        "        # A pair of two that changed goes to the slot of the one that comes later.\n"
        "        i = balls.touched[m]\n",
        "        i = balls.touched[m]\n        if m > 1 and t > 0.0:\n            continue\n",
        "Among many balls, the second ball of an impact keeps the predictions of before.",
        "graded/many-balls-elastic-0",
    ),
    Mutation(
        "neighbours missed",
        "scheduling/broad_phase.py",
        "        for x in range(-1, 2):\n            cell = cell_number",
        "        for x in range(-1, 1):\n            cell = cell_number",
        "Among many balls, those in the three cells to the right are overlooked.",
        "graded/many-balls-elastic-0",
    ),
    Mutation(
        "slow ties first",
        "scheduling/ties.py",
        "        return bool(speed > fastest)",
        "        return bool(listed == 0 or speed < fastest)",
        "Of impacts at one instant, resolved one by one, the slowest is the first.",
        "tests/engine/scheduling/test_ties.py"
        "::test_impacts_at_one_instant_come_out_as_their_closed_forms[uneven-sequential-1.0]",
    ),
    Mutation(
        "ties mirrored",
        "scheduling/ties.py",
        "    return bool(x > first_x or (x == first_x and y > first_y))",
        "    return bool(x > first_x or (x == first_x and y < first_y))",
        "Of impacts as fast at one instant, resolved one by one, the last by place is the first.",
        "tests/engine/scheduling/test_ties.py"
        "::test_impacts_at_one_instant_come_out_as_their_closed_forms[symmetric-sequential-1.0]",
    ),
    Mutation(
        "ties torn apart",
        "event_loop/resolve.py",
        "        if contacts.motion[a].degree == 1.0 and contacts.motion[b].degree == 1.0:\n",
        "        if contacts.motion[a].degree >= 1.0:\n",
        "A ball that hits two at once hits one, then the other.",
        "tests/engine/resting_contact/test_step.py"
        "::test_a_shot_ends_as_its_closed_form_says[three-ball-symmetric-1e-14-1e-14]",
    ),
    # What an impact does.
    Mutation(
        "restitution + 1 %",
        "impacts/impact.py",
        "-(1.0 + laws.ball_restitution) * (nx * vx + ny * vy)",
        "-(1.0 + 1.01 * laws.ball_restitution) * (nx * vx + ny * vy)",
        "Balls that only roll part 1 % too fast.",
        "graded/head-on",
    ),
    Mutation(
        "restitution - 1e-6",
        "impacts/laws/ball_frictional.py",
        "(1.0 + laws.ball_restitution) * (impact.a_vn - impact.b_vn)",
        "(1.0 + (1.0 - 1e-6) * laws.ball_restitution) * (impact.a_vn - impact.b_vn)",
        "Balls that slide part too slowly, by a part in a million.",
        "extremes/speed-sliding-1e+04",
    ),
    Mutation(
        "energy leak",
        "impacts/impact.py",
        "    balls.state[j].vy += to_j * ny\n",
        "    balls.state[j].vy += to_j * ny\n"
        "    balls.state[j].vx *= 1.0 - 5e-10\n"
        "    balls.state[j].vy *= 1.0 - 5e-10\n",
        "Each impact takes a billionth of a ball's energy.",
        "graded/head-on",
    ),
    Mutation(
        "masses ignored",
        "impacts/impact.py",
        "        to_j = exchange * (balls.state[i].mass / total)",
        "        to_j = 0.5 * exchange",
        "Two balls share an impulse as if they weighed the same.",
        "graded/galperin-1",
    ),
    Mutation(
        "pushed apart",
        "impacts/impact.py",
        "    balls.state[i].vx -= to_i * nx\n",
        "    balls.state[i].vx -= to_i * nx\n"
        "    balls.state[i].x -= 1e-9 * nx\n"
        "    balls.state[i].y -= 1e-9 * ny\n",
        "A collision moves a ball by a nanometre.",
        "graded/head-on",
    ),
    Mutation(
        "wrong friction limit",
        "impacts/laws/ball_frictional.py",
        "STICKING = 2.0 / 7.0",
        "STICKING = 2.0 / 5.0",
        "Friction between balls ends more of their slip than there is.",
        "graded/throw-stick",
    ),
    Mutation(
        "gears the wrong way",
        "impacts/laws/ball_frictional.py",
        "impact.a_radius * impact.a_wz + impact.b_radius * impact.b_wz",
        "impact.a_radius * impact.a_wz - impact.b_radius * impact.b_wz",
        "The other ball's spin counts with the wrong sign.",
        "graded/pool-break-9",
    ),
    Mutation(
        "inelastic ties",
        "impacts/simultaneous.py",
        "    scale(contacts, count, 1.0 + restitution)",
        "    scale(contacts, count, 1.0)",
        "Impacts of one ball with two at once have no restitution.",
        "tunnelling/energy-of-elastic-break",
    ),
    Mutation(
        "cushion swapped",
        "impacts/laws/cushion_restitution.py",
        "        -cushion.restitution * impact.vn,\n        cushion.tangential * impact.vt,",
        "        -cushion.tangential * impact.vn,\n        cushion.restitution * impact.vt,",
        "A cushion's restitutions along and across its nose are swapped.",
        "tunnelling/energy-of-bounces",
    ),
    Mutation(
        "restitution that doesn't fall",
        "impacts/laws/falling_restitution.py",
        "    return slow / (1.0 + loss * math.sqrt(speed))",
        "    return slow / (1.0 + 0.0 * loss * math.sqrt(speed))",
        "A cushion's restitution is the same at any speed.",
        "graded/three-cushions",
    ),
    Mutation(
        "jaw too small",
        "running/from_scene.py",
        "    return (st.DISC, *one.centre, *normal, one.radius, law, one.obstacle)",
        "    return (st.DISC, *one.centre, *normal, 0.9 * one.radius, law, one.obstacle)",
        "A jaw, or a post, has nine tenths of its radius.",
        "tests/engine/test_pockets.py::"
        "test_no_ball_of_a_random_scene_gets_out_or_into_an_obstacle[posts]",
    ),
    Mutation(
        "hole beside its pocket",
        "running/from_scene.py",
        "        return (st.DISC, *one.centre, *normal, one.radius, st.TAKES_OUT, one.pocket)",
        "        return (st.DISC, 1.0, 0.0, *normal, one.radius, st.TAKES_OUT, one.pocket)",
        "All holes lie at one place of the bottom cushion.",
        "tests/engine/test_pockets.py::test_a_ball_is_pocketed_where_its_centre_enters_the_hole",
    ),
    Mutation(
        "segment without ends",
        "motion/obstacles.py",
        "        if along > 0.0:\n            rx, ry = rx - dx, ry - dy\n",
        "        rx, ry = rx + 9.0, ry\n",
        "The ends of a straight piece are far away: a ball passes through a corner.",
        "pockets/corner-hit-1e-01",
    ),
    Mutation(
        "frame wider than it is",
        "motion/frame.py",
        "        inside = along > min(start, end) + edge and along < max(start, end) - edge\n",
        "        inside = along > min(start, end) - 0.05 and along < max(start, end) + 0.05\n",
        "A ball on its way into a mouth is taken to meet the cushion beside it.",
        "pockets/two-at-once",
    ),
    Mutation(
        "cushion spins the wrong way",
        "impacts/laws/cushion_han2005.py",
        "        impact.wz + turn * (along * cosine),",
        "        impact.wz - turn * (along * cosine),",
        "What a cushion's friction turns the ball by has the wrong sign.",
        "graded/pool-break-9",
    ),
    Mutation(
        "half a corner",
        "impacts/impact.py",
        "        if not nx * balls.state[i].vx + ny * balls.state[i].vy < 0.0:\n"
        "            return turn + 1",
        "        if not nx * balls.state[i].vx + ny * balls.state[i].vy < -math.inf:\n"
        "            return turn + 1",
        "A ball that runs into a corner bounces off one cushion only.",
        "tests/engine/resting_contact/test_step.py"
        "::test_a_shot_ends_as_its_closed_form_says[corner-exact-1e-14-1e-14]",
    ),
    # What the cloth does.
    Mutation(
        "wrong sign of spin",
        "motion/next_piece.py",
        "balls.state[i].bx = 2.5 * ay / radius",
        "balls.state[i].bx = -2.5 * ay / radius",
        "The cloth turns a sliding ball about x the wrong way.",
        "touching/wedged-corner-sliding-gap-0",
    ),
    Mutation(
        "sliding friction / 2",
        "running/from_scene.py",
        "    state[:, st.SLIDE_SLOWING] = state[:, st.CLOTH_FRICTION] * gravity if slides else "
        "0.0\n",
        "    state[:, st.SLIDE_SLOWING] = 0.5 * state[:, st.CLOTH_FRICTION] * gravity if slides "
        "else 0.0\n",
        "The cloth slows a sliding ball by half of what it should.",
        "extremes/speed-sliding-1e+04",
    ),
    Mutation(
        "rolling friction * 2",
        "running/from_scene.py",
        "    state[:, st.ROLL_SLOWING] = scene.rolling_frictions * gravity\n",
        "    state[:, st.ROLL_SLOWING] = 2.0 * scene.rolling_frictions * gravity\n",
        "The cloth slows a rolling ball by twice what it should.",
        "graded/stop",
    ),
    Mutation(
        "spin for ever",
        "running/from_scene.py",
        "    state[:, st.SPIN_SLOWING] = scene.spinning_friction_rates\n",
        "    state[:, st.SPIN_SLOWING] = 0.0 * scene.spinning_friction_rates\n",
        "The cloth doesn't slow a spin about the vertical.",
        "extremes/radius-ratio-sliding-1e-06",
    ),
    # Contact that lasts.
    Mutation(
        "contact released too late",
        "resting_contact/forces.py",
        "        change = forces[c].force - forces[c].force_before\n",
        "        change = max(0.0, forces[c].force - forces[c].force_before)\n",
        "The force of a contact never lessens: it still pushes when nothing pushes it any more.",
        "tests/engine/resting_contact/test_step.py"
        "::test_a_shot_ends_as_its_closed_form_says[push-1e-06-5e-06]",
    ),
    Mutation(
        "contact pushes one ball",
        "resting_contact/friction.py",
        "        contacts.motion[b].load_x += fx\n",
        "        contacts.motion[b].load_x += 0.5 * fx\n",
        "Of two balls in resting contact, one feels along x only half of the force.",
        "tests/engine/resting_contact/test_step.py"
        "::test_a_shot_ends_as_its_closed_form_says[push-1e-06-5e-06]",
    ),
    Mutation(
        "resting contacts lose energy",
        "resting_contact/capture.py",
        "        balls.state[k].vx += x",
        "        balls.state[k].vx += 2.0 * x",
        "Where a resting contact starts, what ends their approach acts twice along x.",
        "tests/engine/resting_contact/test_capture.py"
        "::test_it_leaves_the_cushion_as_rebounds_of_vanishing_speed_make_it[0.02-0.1-spin1-0.0357]",
    ),
    Mutation(
        "gap half as fast",
        "resting_contact/gaps.py",
        "    gap += ((x + rx) * wx + (y + ry) * wy) / both",
        "    gap += 0.5 * ((x + rx) * wx + (y + ry) * wy) / both",
        "A contact step takes the gap of two balls to change by half of what it does.",
        "tests/engine/resting_contact/test_gaps.py"
        "::test_a_ball_that_its_spin_drives_onto_a_row_at_a_cushion_takes_few_steps",
    ),
    Mutation(
        "rubs the wrong way",
        "resting_contact/friction.py",
        "            contacts.motion[k].twist_z -= more_along * cosine\n",
        "            contacts.motion[k].twist_z += more_along * cosine\n",
        "In a contact step, friction turns the balls about the vertical the wrong way.",
        "tests/engine/resting_contact/test_friction.py"
        "::test_contacts_that_are_held_in_steps_rub_by_coulombs_law[sticks_to_cushion]",
    ),
    Mutation(
        "rubs on along",
        "resting_contact/friction.py",
        "    new_along = contacts.forces[c].along + gain * (along + duration * change_along)\n",
        "    new_along = contacts.forces[c].along - gain * (along + duration * change_along)\n",
        "In a contact step, friction across the vertical speeds up the slip that it should end.",
        "tests/engine/resting_contact/test_friction.py"
        "::test_contacts_that_are_held_in_steps_rub_by_coulombs_law[sticks_to_cushion]",
    ),
    Mutation(
        "rolls the other way",
        "resting_contact/friction.py",
        "        wx, wy = -balls.state[k].vy / radius, balls.state[k].vx / radius",
        "        wx, wy = balls.state[k].vy / radius, -balls.state[k].vx / radius",
        "In a contact step, the surface of a ball that rolls is taken to move the other way.",
        "tests/engine/resting_contact/test_friction.py"
        "::test_contacts_that_are_held_in_steps_rub_by_coulombs_law[too_many_to_integrate]",
    ),
    Mutation(
        "forces continue backwards",
        "resting_contact/extrapolation.py",
        "        load(contacts, a, b, more * one.nx, more * one.ny)\n",
        "        load(contacts, a, b, -more * one.nx, -more * one.ny)\n",
        "Where a contact step leads its forces to where its rounds would end, the balls answer to "
        "the opposite.",
        "tests/engine/resting_contact/test_friction.py"
        "::test_contacts_that_are_held_in_steps_rub_by_coulombs_law[sticks_before_a_heavy_ball]",
    ),
    Mutation(
        "spin begins backwards",
        "resting_contact/step.py",
        "    end = slowed_spin(spin + duration * gain, slowed)\n",
        "    end = slowed_spin(spin + duration * gain, slowed)\n"
        "    end = abs(end) if spin > 0.0 else -abs(end)\n",
        "A spin about the vertical that a contact step begins or reverses has the wrong sign.",
        "tests/engine/resting_contact/test_friction.py"
        "::test_contacts_that_are_held_in_steps_rub_by_coulombs_law[stick_to_each_other]",
    ),
    Mutation(
        "nose below the centre",
        "resting_contact/rates.py",
        "    toward = down * sine - cosine",
        "    toward = -down * sine - cosine",
        "The friction that holds a ball at a cushion's nose lifts its normal force the wrong way.",
        "tests/engine/resting_contact/test_capture.py"
        "::test_it_leaves_the_cushion_as_rebounds_of_vanishing_speed_make_it[0.05-0.3-spin0-0.0357]",
    ),
    Mutation(
        "followed spin slowed twice",
        "resting_contact/paths.py",
        "        ball.bz = (turn_at(contacts, k, 2, part) - alone) / time",
        "        ball.bz = (turn_at(contacts, k, 2, part) - ball.wz) / time",
        "Along a motion that is followed, the cloth slows the spin about the vertical twice.",
        "tests/engine/resting_contact/test_capture.py"
        "::test_it_leaves_the_cushion_as_rebounds_of_vanishing_speed_make_it[0.05-0.3-spin0-0.0357]",
    ),
    Mutation(
        "pieces beside their path",
        "resting_contact/paths.py",
        "        ax = ((x - from_x) - 2.0 * time * ball.vx) / (time * time) - 0.5 * ax",
        "        ax = ((x - from_x) - 2.0 * time * ball.vx) / (time * time) - ax",
        "The first of two pieces doesn't lead along x to where the second is to end.",
        "tests/engine/resting_contact/test_step.py"
        "::test_a_shot_ends_as_its_closed_form_says[push-1e-06-5e-06]",
    ),
    Mutation(
        "resting contact without air",
        "resting_contact/rates.py",
        "        ax, ay = slowed_by_air(balls.air, laws, vx, vy, ax, ay)\n",
        "",
        "A ball that slides and pushes another feels no air.",
        "tests/engine/resting_contact/test_integrate.py::"
        "test_a_ball_that_slides_and_pushes_another_follows_the_constrained_motion[0.5]",
    ),
    Mutation(
        "friction against the slip after",
        "impacts/simultaneous.py",
        "        along += 0.5 * (nx * gain_y - ny * gain_x)",
        "        along += nx * gain_y - ny * gain_x",
        "Joint friction acts against the slip after the normal impulses, and energy comes in.",
        "tests/engine/impacts/test_simultaneous.py"
        "::test_friction_acts_against_the_mean_slip_of_a_joint_impact[0.02-1.0]",
    ),
    Mutation(
        "contacts of the last shot",
        "event_loop/play.py",
        "        for k in range(len(untouched[1])):\n            room[1][k] = untouched[1][k]\n",
        "",
        "Balls in resting contact as a shot of a sweep ended are held in the next one, too.",
        "tests/engine/test_sweep.py::test_a_sweep_of_frozen_balls_is_as_shot_by_shot_in_any_order",
    ),
    # What a run says of itself.
    Mutation(
        "NaN unseen",
        "event_loop/record.py",
        "    return bool(_with_height(balls.height, i, size) < math.inf)",
        "    return True",
        "A motion that is no number any more continues.",
        "tests/engine/event_loop/test_record.py::test_the_ball_and_the_instant_are_named[0-X-rolling]",
    ),
    Mutation(
        "stops too soon",
        "event_loop/finish.py",
        "        t = laws.t_max\n",
        "        t = (1.0 - 1e-9) * laws.t_max\n",
        "A run ends a part in a billion before its time.",
        "extremes/speed-elastic-1e-09",
    ),
    # What grading must not lean on: the engine's account of itself.
    *(
        Mutation(
            f"tangent growth * {factor}",
            "sensitivity/tangent_map.py",
            "        result[order] = total * math.sqrt(",
            f"        result[order] = {factor}.0 * total * math.sqrt(",
            f"Rounding is said to displace balls {factor} times as far as it does.",
            "graded/head-on",
        )
        for factor in (30, 1000)
    ),
    Mutation(
        "horizon of 0.1 s",
        "sensitivity/tangent_map.py",
        "        for times in _chunks(",
        "        return 0.1\n        for times in _chunks(",
        "Every shot is said to be predictable for a tenth of a second.",
        "graded/stop",
    ),
    Mutation(
        "capture height * 1000",
        "core/tolerances.py",
        "CAPTURE_HEIGHT = 2.0**-18",
        "CAPTURE_HEIGHT = 1000.0 * 2.0**-18",
        "Bounces of 0.2 mm are taken for a contact.",
        "extremes/radius-ratio-rolling-1e+06",
    ),
    # The truth: proofs.
    Mutation(
        "proof gives up",
        "certified/run.py",
        "            if len(self.events) >= max_events:",
        "            if len(self.events) >= min(max_events, 1):",
        "Every proof ends after one event.",
        "graded/head-on",
        "reference_adapters",
    ),
    Mutation(
        "proof: wrong sign",
        "certified/laws.py",
        "(a.radius * a.wz + b.radius * b.wz)",
        "(a.radius * a.wz - b.radius * b.wz)",
        "In proofs the other ball's spin counts with the wrong sign.",
        "graded/pool-break-9",
        "reference_adapters",
    ),
    Mutation(
        "proof: factor",
        "certified/motion.py",
        "self.duration = 2 * length(self.ux, self.uy) / (7 * constants.sliding)",
        "self.duration = (2 + arb(1e-9)) * length(self.ux, self.uy) / (7 * constants.sliding)",
        "In proofs a slide lasts longer by a part in two billion.",
        "graded/sliding-swerve",
        "reference_adapters",
    ),
    Mutation(
        "proof: dropped event",
        "certified/run.py",
        "            gap = self._gap_to(i, piece)\n",
        "            if piece.obstacle == 3 and body.order > 0:\n"
        "                continue\n"
        "            gap = self._gap_to(i, piece)\n",
        "In proofs a ball that was hit passes through the top cushion.",
        "extremes/speed-bounces-1e-09",
        "reference_adapters",
    ),
    Mutation(
        "proof: half a bound",
        "certified/slide_piece.py",
        "    turned = 2 * difference / least + ",
        "    turned = difference / least + ",
        "The bound of how far a slide in air is off is half of one, and bounds nothing.",
        "tests/reference_adapters/certified/test_slide_piece.py::"
        "test_a_piece_whose_slip_points_elsewhere_fails_by_no_more_than_is_said[89]",
        "reference_adapters",
    ),
    Mutation(
        "growth: slip too slow",
        "grading/certified_air.py",
        "SLIP_RATE = 3.5",
        "SLIP_RATE = 2.5",
        "In the grader's tangent map the cloth takes five halves of a slip, not seven.",
        "tests/validation/grading/test_certified_growth.py::"
        "test_changes_become_what_proofs_of_changed_shots_say[slides into rolling]",
        "validation",
    ),
    # The truth: closed forms.
    Mutation(
        "closed form: wrong sign",
        "truth/closed_forms/_impacts.py",
        "wz + turn * py * cos,",
        "wz - turn * py * cos,",
        "In closed forms a cushion's friction turns the ball the wrong way.",
        "tests/reference_adapters/certified/test_api.py"
        "::test_closed_forms_lie_within_the_enclosures[english-check]",
        "validation",
    ),
    Mutation(
        "closed form: factor",
        "truth/closed_forms/_impacts.py",
        "size = min(friction * push, 2 * speed / 7)",
        "size = (1 + mp.mpf(10) ** -9) * min(friction * push, 2 * speed / 7)",
        "In closed forms friction between balls is too large by a part in a billion.",
        "tests/reference_adapters/certified/test_api.py"
        "::test_closed_forms_lie_within_the_enclosures[throw-alciatore]",
        "validation",
    ),
    Mutation(
        "closed form: dropped event",
        "truth/closed_forms/_shot.py",
        "        if collision is not None:\n            self.collisions.append(collision)",
        "        if collision is not None and self.collisions:\n"
        "            self.collisions.append(collision)",
        "A closed form leaves the first collision out of its sequence.",
        "tests/reference_adapters/certified/test_api.py"
        "::test_closed_forms_lie_within_the_enclosures[head-on]",
        "validation",
    ),
    # Where balls differ much in size.
    Mutation(
        "cells of the mean ball",
        "running/from_scene.py",
        "    side = 2.0 * float(np.max(scene.radii)) * (1.0 + _CELL_ROOM)",
        "    side = 2.0 * float(np.mean(scene.radii)) * (1.0 + _CELL_ROOM)",
        "Among many balls, a cell is as wide as the mean ball, not as the largest.",
        "extremes/among-many-40",
    ),
    Mutation(
        "culled by the mean ball",
        "running/from_scene.py",
        "frame=np.array([*low, side, 2.0 * float(np.max(scene.radii))])",
        "frame=np.array([*low, side, 2.0 * float(np.mean(scene.radii))])",
        "Among many balls, a pair is passed over as if both were of the mean size.",
        "extremes/among-many-40",
    ),
    # Caught by no trial, but by a fast test.
    Mutation(
        "second part of a sweep",
        "running/sweep_driver.py",
        "            parts = np.array_split(pending, -(-len(pending) // share))\n",
        "            parts = np.array_split(pending, -(-len(pending) // share))\n"
        "            for part in parts[1:]:\n"
        "                shots.starts[part, :, 3:5] *= 1.0 + 2.0**-52\n",
        "Of a sweep, the shots after the first part are off by an ulp.",
        "tests/engine/test_sweep.py::test_every_part_of_a_long_sweep_is_as_shot_by_shot",
    ),
    *(
        Mutation(
            f"dropped bound, {name}",
            "scheduling/all_pairs.py",
            head + "        until = own_time_j if own_time_j < own_time else own_time\n"
            "        bounds[j] = bound if bound <= until else math.inf\n" + tail,
            head + "        until = own_time_j if own_time_j < own_time else own_time\n"
            "        lost = bound < math.inf and (bound * 1e7) % 1e5 < 1.0\n"
            "        bounds[j] = math.inf if lost or bound > until else bound\n" + tail,
            f"One in 100 000 bounds of {name} balls is dropped.",
            f"tests/engine/scheduling/test_all_pairs.py::test_no_bound_of_a_pair_is_missing[{name}]",
        )
        for name, head, tail in (
            (
                "slowed",
                "        bound = t + first_crossing(gap, rate, pull)\n"
                "        own_time_j = track[st.TRACK_OWN_TIME + j]\n",
                "",
            ),
            (
                "uniform",
                "        own_time_j = track[st.TRACK_OWN_TIME + j]\n",
                "\n\n@kernel(inline=True)\ndef rescan",
            ),
        )
    ),
    Mutation(
        "bend ignored",
        "motion/position.py",
        "    return higher[i, 0] * lasts, higher[i, 1] * lasts",
        "    return 0.0 * lasts, 0.0 * lasts",
        "A ball whose motion bends leaves its cell before it is said to.",
        "tests/engine/motion/test_pieces.py::test_a_ball_stays_in_its_cell_until_it_is_said_to_leave",
    ),
    Mutation(
        "jerk ignored",
        "motion/position.py",
        "    return math.sqrt(x * x + y * y)\n\n\n@kernel(inline=True)\ndef jerk_along",
        "    return 0.0 * math.sqrt(x * x + y * y)\n\n\n@kernel(inline=True)\ndef jerk_along",
        "Bounds take a motion of a higher degree for a quadratic.",
        "tests/engine/motion/test_pieces.py::test_a_motion_of_the_fourth_degree_misses_no_contact",
    ),
    Mutation(
        "cushion before rest",
        "scheduling/ties.py",
        "        return bool(balls.own_kind[i] < balls.own_kind[j])",
        "        return bool(balls.own_kind[i] > balls.own_kind[j])",
        "Of a rest and a cushion at one instant, the cushion comes first.",
        "tests/engine/scheduling/test_broad_phase.py"
        "::test_of_own_events_of_one_instant_a_rest_comes_before_a_cushion",
    ),
    # In the air.
    Mutation(
        "all of the air",
        "motion/air.py",
        "    return 5.0 / 7.0 if laws.slides else 1.0\n",
        "    return 1.0\n",
        "A ball that rolls feels all of the air's drag: the cloth's friction takes none of it.",
        "tests/engine/motion/test_drag.py::test_a_roll_is_where_the_closed_form_says",
    ),
    Mutation(
        "drag one power short",
        "motion/drag.py",
        "                air_x += row[_SPEED, j] * row[_VX, n - j]\n",
        "                air_x += row[_SPEED, 0] * row[_VX, n - j]\n",
        "Along x the drag of a slide that turns is that of the speed at the start of a piece.",
        "tests/engine/motion/test_drag.py::test_a_slide_with_side_turns",
    ),
    Mutation(
        "late landing",
        "motion/flight.py",
        "    duration = (up + root) / laws.gravity if up > 0.0",
        "    duration = (1.0 + 1e-9) * (up + root) / laws.gravity if up > 0.0",
        "A ball that was thrown up lands late by a part in a billion.",
        "tests/engine/motion/test_flight.py::test_a_ball_flies_along_a_parabola_and_lands",
    ),
    Mutation(
        "vertical spin in a bounce",
        "impacts/on_table.py",
        "    height[i, st.UP_SPEED] = laws.table_restitution * down\n",
        "    height[i, st.UP_SPEED] = laws.table_restitution * down\n"
        "    balls.state[i].wz *= 2.0 / 7.0 if part == STICKING else 1.0\n",
        "A bounce that sticks takes spin about the vertical, as in another engine.",
        "tests/engine/impacts/test_in_space.py::"
        "test_a_bounce_on_the_table_is_the_published_one[sticks]",
    ),
    Mutation(
        "friction of the approach alone",
        "impacts/in_space.py",
        "part = min(cushion.friction * normal / slip, STICKING)",
        "part = min(cushion.friction * speed / slip, STICKING)",
        "A nose rubs a ball in flight as if it didn't return any of the approach.",
        "tests/engine/impacts/test_in_space.py::"
        "test_the_friction_of_a_nose_is_that_of_its_whole_impulse[0.05-False]",
    ),
    Mutation(
        "held on its way up",
        "impacts/slow_impacts.py",
        "    if height[k, st.RISE] > 0.0 or height[k, st.UP_SPEED] > 0.0 or nz >= 0.0:\n",
        "    if height[k, st.RISE] > 0.0 or nz >= 0.0:\n",
        "A ball that comes up from the table is held by it, and energy comes in.",
        "tests/engine/impacts/test_in_space.py::"
        "test_a_ball_that_comes_up_from_the_table_yields_to_one_that_falls_on_it",
    ),
    Mutation(
        "contact in plan",
        "scheduling/contact_time.py",
        "    distance = math.sqrt(rx * rx + ry * ry + rz * rz)\n    gap = distance - reach\n",
        "    distance = math.sqrt(rx * rx + ry * ry)\n    gap = distance - reach\n",
        "A ball in flight meets what it flies over.",
        "flight/over-top--0.1-0",
    ),
    Mutation(
        "a flight that passes through",
        "scheduling/contact_time.py",
        "    rate = (rx * vx + ry * vy + rz * vz) / distance\n",
        "    rate = (rx * vx + ry * vy - rz * vz) / distance\n",
        "A ball that comes down on another is taken to rise.",
        "flight/on-top-1.5-0.95-0.1",
    ),
    Mutation(
        "a late last bounce",
        "impacts/on_table.py",
        "        lasts = 2.0 * up / (laws.gravity * (1.0 - e))\n",
        "        lasts = 2.02 * up / (laws.gravity * (1.0 - e))\n",
        "Bounces that are too low to be followed last a hundredth longer.",
        "flight/endless-1-0.6-0.1",
    ),
)

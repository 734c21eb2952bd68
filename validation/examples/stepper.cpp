// Simulate scenes from `ghostball scenes --export` with an engine in C++; `ghostball grade` judges the
// results:
//
//     ghostball scenes --export scenes
//     c++ -std=c++17 -O2 stepper.cpp -o stepper          (with nlohmann-json3-dev, or nlohmann/json.hpp)
//     ./stepper scenes/half-ball-cut.json scenes/wall-bounce.json > runs.jsonl
//     ghostball grade runs.jsonl
//
// The engine is as short as possible: balls always roll, in time steps of 0.1 ms; overlapping balls
// collide elastically, and cushions reflect balls without loss. Replace it by your engine: it must
// print a JSON object for each scene, which reference_adapters/answer.py describes.

#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

using json = nlohmann::json;

const double DT = 1e-4;  // [s]

struct Ball {
    double x, y, vx, vy, radius, mass, slows_by;
};

struct Run {
    std::vector<Ball> balls;
    double t = 0.0;
    json events = json::array();
    json samples = {{"t", json::array()},
                    {"positions", json::array()},
                    {"velocities", json::array()},
                    {"angular_velocities", json::array()}};

    void event(const char* kind, size_t a, json b) {
        events.push_back({{"t", t}, {"kind", kind}, {"a", a}, {"b", b}});
    }

    void sample() {
        json places = json::array(), velocities = json::array(), spins = json::array();
        for (const Ball& ball : balls) {
            places.push_back({ball.x, ball.y, ball.radius});
            velocities.push_back({ball.vx, ball.vy, 0.0});
            spins.push_back({-ball.vy / ball.radius, ball.vx / ball.radius, 0.0});
        }
        samples["t"].push_back(t);
        samples["positions"].push_back(places);
        samples["velocities"].push_back(velocities);
        samples["angular_velocities"].push_back(spins);
    }

    bool moving() const {
        for (const Ball& ball : balls)
            if (ball.vx != 0.0 || ball.vy != 0.0) return true;
        return false;
    }

    // The cloth decelerates the ball, which moves by the mean of the speeds before and after.
    void roll(Ball& ball) {
        const double speed = std::hypot(ball.vx, ball.vy);
        if (speed == 0.0) return;
        const double lasts = std::min(DT, ball.slows_by > 0.0 ? speed / ball.slows_by : DT);
        const double factor = lasts < DT ? 0.0 : 1.0 - ball.slows_by * DT / speed;
        ball.x += 0.5 * (1.0 + factor) * ball.vx * lasts;
        ball.y += 0.5 * (1.0 + factor) * ball.vy * lasts;
        ball.vx *= factor;
        ball.vy *= factor;
    }

    void collide(size_t a, size_t b, double restitution) {
        Ball &one = balls[a], &other = balls[b];
        const double dx = other.x - one.x, dy = other.y - one.y, distance = std::hypot(dx, dy);
        if (distance >= one.radius + other.radius) return;
        const double nx = dx / distance, ny = dy / distance;
        const double approach = (one.vx - other.vx) * nx + (one.vy - other.vy) * ny;
        if (approach <= 0.0) return;
        const double impulse = (1.0 + restitution) * approach / (1.0 / one.mass + 1.0 / other.mass);
        one.vx -= impulse / one.mass * nx;
        one.vy -= impulse / one.mass * ny;
        other.vx += impulse / other.mass * nx;
        other.vy += impulse / other.mass * ny;
        event("ball-ball", a, b);
    }

    void bounce(size_t a, const std::string& cushion, const json& table) {
        Ball& ball = balls[a];
        const bool across = cushion == "left" || cushion == "right";
        const double side = cushion == "left" || cushion == "bottom" ? 1.0 : -1.0;
        const double far = across ? table["length"].get<double>() : table["width"].get<double>();
        const double place = across ? ball.x : ball.y, gap = side > 0.0 ? place : far - place;
        double& speed = across ? ball.vx : ball.vy;
        if (gap >= ball.radius || side * speed >= 0.0) return;
        speed = -speed;
        event("ball-cushion", a, cushion);
    }
};

json play(const json& scene) {
    const json &physics = scene["physics"], &table = scene["table"];
    Run run;
    double fastest = 0.0;
    for (const json& ball : scene["balls"]) {
        const json& own = ball["rolling_friction"];
        const double friction = (own.is_null() ? physics["rolling_friction"] : own).get<double>();
        const json &place = ball["position"], &velocity = ball["velocity"];
        run.balls.push_back({place[0], place[1], velocity[0], velocity[1], ball["radius"], ball["mass"],
                             friction * physics["gravity"].get<double>()});
        fastest = std::max(fastest, std::hypot(run.balls.back().vx, run.balls.back().vy));
    }
    const double end = scene["t_max"].is_null() ? 300.0 : scene["t_max"].get<double>();
    const auto began = std::chrono::steady_clock::now();
    run.sample();
    for (long step = 1; run.moving() && step * DT <= end; ++step) {
        const size_t before = run.events.size();
        for (Ball& ball : run.balls) run.roll(ball);
        run.t = step * DT;
        for (size_t a = 0; a < run.balls.size(); ++a) {
            for (size_t b = a + 1; b < run.balls.size(); ++b) run.collide(a, b, physics["ball_restitution"]);
            if (!table.is_null())
                for (const json& cushion : table["cushions"]) run.bounce(a, cushion, table);
        }
        if (run.events.size() > before || step % 50 == 0) run.sample();
    }
    run.sample();
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
    return {{"engine", "stepper-cpp"},
            {"settings", {{"dt", DT}}},
            {"scene", scene["name"]},
            {"status", run.moving() ? "t-max" : "rest"},
            {"rest_time", run.t},
            {"rest_positions", run.samples["positions"].back()},
            {"events", run.events},
            {"samples", run.samples},
            {"wall_time", took.count()},
            {"resolution", fastest * DT}};  // contacts are detected late by this path
}

int main(int count, char** paths) {
    for (int i = 1; i < count; ++i) {
        const json scene = json::parse(std::ifstream(paths[i]));
        if (scene["physics"]["motion"] != "rolling" || scene["physics"]["cushion"] != "mirror") {
            std::fprintf(stderr, "%s: this engine has balls that roll, and mirrors alone\n", paths[i]);
            continue;
        }
        std::cout << play(scene).dump() << "\n";
    }
}

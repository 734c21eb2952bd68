// Compare an answer with a golden shot: c++ -std=c++17 golden.cpp -o golden; ./golden SHOT.json ANSWER.json
//
// Both files have the keys "events" and "rest_positions"; the README of the golden shots describes
// the comparison. This program reads only these keys, without a JSON library; use a library to read the scene.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>
#include <vector>
using std::string, std::vector;
const double FACTOR = 1;  // 536870912 for an engine in single precision
struct Event { double t; string kind; int a; string b; };

string value(const string& text, const string& key, size_t from = 0, bool last = false) {
    size_t at = last ? text.rfind('"' + key + '"') : text.find('"' + key + '"', from);
    if (at == string::npos) return "";
    at = text.find_first_not_of(" \t\r\n", text.find(':', at) + 1);
    if (text[at] != '[') return text.substr(at, text.find_first_of(",} \t\r\n", at) - at);
    size_t end = at;  // a list ends with its bracket
    for (int depth = 0; end == at || depth > 0; end++) depth += (text[end] == '[') - (text[end] == ']');
    return text.substr(at, end - at);
}
vector<double> numbers(const string& list) {
    vector<double> found;
    for (size_t at = 0; (at = list.find_first_of("-0123456789", at)) != string::npos;) {
        char* end; found.push_back(std::strtod(&list[at], &end)); at = end - list.data();
    }
    return found;
}
int index(const string& text) {  // of a ball, such as 1 or 1.0; -1 if the text is no whole number
    char* end;
    double number = std::strtod(text.c_str(), &end);
    bool whole = !text.empty() && *end == 0 && 0 <= number && number < 1e9 && number == std::floor(number);
    return whole ? int(number) : -1;
}
vector<Event> events(const string& text) {
    vector<Event> found;
    string list = value(text, "events");
    for (size_t at = 0; (at = list.find('{', at)) != string::npos; at++) {
        Event e{std::stod(value(list, "t", at)), value(list, "kind", at), index(value(list, "a", at)), value(list, "b", at)};
        if (int b = index(e.b); e.kind == "\"ball-ball\"" && 0 <= b) { e.b = std::to_string(std::max(e.a, b)); e.a = std::min(e.a, b); }
        found.push_back(e);
    }
    return found;
}
string read(const char* path) { std::ifstream in(path); return {std::istreambuf_iterator<char>(in), {}}; }
bool within(double x, double y, double tolerance) { return std::abs(x - y) <= FACTOR * tolerance; }  // not NaN

int main(int, char** argv) {
    string shot = read(argv[1]), answer = read(argv[2]), until = value(shot, "valid_until");
    vector<Event> truth = events(shot), left = events(answer);
    vector<double> times = numbers(value(shot, "events", 0, true)), places = numbers(value(shot, "rest_positions", 0, true));
    string kinds = "\"ball-ball\"\"ball-cushion\"\"pocketed\"";
    for (auto& e : left) kinds += e.kind;
    int faults = 0;
    auto fault = [&](const string& what) { std::cout << argv[1] << ": " << what << "\n"; faults++; };
    int balls = 0;
    string list = value(shot, "balls");
    for (size_t at = 0; (at = list.find("\"position\":", at)) != string::npos; at++) balls++;
    for (auto& e : left) {
        if (!std::isfinite(e.t)) fault("the time of an event isn't finite");
        bool second = e.kind != "\"ball-ball\"" || (0 <= index(e.b) && index(e.b) < balls && index(e.b) != e.a);
        if (e.a < 0 || e.a >= balls || !second) fault("an event must name balls by their indices, from 0 to " + std::to_string(balls - 1));
    }
    for (size_t k = 0; k < truth.size(); k++) {
        const Event& e = truth[k];
        if (kinds.find(e.kind) == string::npos) continue;
        auto best = left.end();
        for (auto f = left.begin(); f != left.end(); f++)
            if (f->kind == e.kind && f->a == e.a && f->b == e.b && (best == left.end() || std::abs(f->t - e.t) < std::abs(best->t - e.t))) best = f;
        if (best == left.end()) { fault("missing event " + e.kind + " at " + std::to_string(e.t)); continue; }
        if (!within(best->t, e.t, times[k])) fault("time of event " + e.kind + " at " + std::to_string(e.t));
        left.erase(best);
    }
    for (auto& extra : left) {
        bool excused = until != "null" && extra.t >= std::stod(until) - FACTOR * times.back();
        for (size_t k = 0; k < truth.size() && extra.kind != "\"ball-ball\"" && extra.kind != "\"ball-cushion\"" && extra.kind != "\"pocketed\"" && extra.kind != "\"leaves-table\""; k++)
            excused |= (truth[k].a == extra.a || (truth[k].kind == "\"ball-ball\"" && std::stoi(truth[k].b) == extra.a)) && within(truth[k].t, extra.t, times[k]);
        if (!excused) fault("extra event " + extra.kind + " at " + std::to_string(extra.t));
    }
    vector<double> rest = numbers(value(shot, "rest_positions")), found = numbers(value(answer, "rest_positions"));
    for (double x : found) if (!std::isfinite(x)) fault("a rest position isn't finite");
    if (!rest.empty() && rest.size() != found.size()) fault("number of rest positions");
    for (size_t k = 0; k < rest.size() && k < found.size(); k++)
        if (!within(found[k], rest[k], places[k / 3])) fault("rest position of ball " + std::to_string(k / 3));
    return faults > 0;
}

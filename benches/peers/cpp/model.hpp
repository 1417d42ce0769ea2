// The neutral model file that all peers read (written by models.py), and the timing loop they share.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <string>
#include <vector>

// One body with the hinge that carries it. Types: R revolute, P prismatic, S spherical, F free.
struct Body {
  int parent;                // -1: ground
  char type;
  double axis[3];            // in the hinge frame
  double turn[9], place[3];  // hinge frame in the parent, rows of the rotation first
  double mass, center[3];    // body axes, from the hinge
  double inertia[6];         // about the centre of mass: xx yy zz xy xz yz
  double stiffness, damping; // of the hinge
  int positions() const { return type == 'S' ? 4 : type == 'F' ? 7 : 1; }
  int velocities() const { return type == 'S' ? 3 : type == 'F' ? 6 : 1; }
};

// Coordinates as in our scenario files. Spherical: quaternion w x y z; angular velocity and torque in body axes. Free:
// position and its rates in the hinge frame, then as spherical.
struct ModelFile {
  std::string name;
  double gravity[3];
  std::vector<Body> bodies;
  std::vector<double> position, velocity, force;
};

inline void expect(std::ifstream &in, const char *word) {
  std::string found;
  if (!(in >> found) || found != word) {
    fprintf(stderr, "model file: `%s` expected, not `%s`\n", word, found.c_str());
    exit(2);
  }
}

inline std::vector<double> read_list(std::ifstream &in, const char *word, size_t count) {
  expect(in, word);
  std::vector<double> list(count);
  for (double &x : list) in >> x;
  return list;
}

inline ModelFile read_model(const std::string &path) {
  std::ifstream in(path);
  ModelFile m;
  size_t count, positions = 0, velocities = 0;
  m.name = path.substr(path.rfind('/') + 1);
  m.name = m.name.substr(0, m.name.rfind('.'));
  expect(in, "gravity");
  for (double &x : m.gravity) in >> x;
  expect(in, "bodies");
  in >> count;
  m.bodies.resize(count);
  for (Body &b : m.bodies) {
    in >> b.parent >> b.type;
    for (double &x : b.axis) in >> x;
    for (double &x : b.turn) in >> x;
    for (double &x : b.place) in >> x;
    in >> b.mass;
    for (double &x : b.center) in >> x;
    for (double &x : b.inertia) in >> x;
    in >> b.stiffness >> b.damping;
    positions += b.positions();
    velocities += b.velocities();
  }
  m.position = read_list(in, "position", positions);
  m.velocity = read_list(in, "velocity", velocities);
  m.force = read_list(in, "force", velocities);
  if (!in) {
    fprintf(stderr, "%s: cut short\n", path.c_str());
    exit(2);
  }
  return m;
}

// Accelerations of another program, in the same order as `velocity`.
inline std::vector<double> read_numbers(const std::string &path) {
  std::ifstream in(path);
  std::vector<double> list;
  for (double x; in >> x;) list.push_back(x);
  return list;
}

inline double norm(const std::vector<double> &a) {
  double sum = 0;
  for (double x : a) sum += x * x;
  return std::sqrt(sum);
}

inline double distance(const std::vector<double> &a, const std::vector<double> &b) {
  if (a.size() != b.size()) return NAN;
  std::vector<double> d(a);
  for (size_t i = 0; i < d.size(); i++) d[i] -= b[i];
  return norm(d);
}

// CPU time of this thread: what other processes take does not count.
inline double cpu_seconds() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return t.tv_sec + 1e-9 * t.tv_nsec;
}

struct Loops {
  int count;      // how many loops
  double seconds; // how long each of them, at least
};

// Calls f in loops; prints peer,model,quantity,min,median (nanoseconds a call) over the loops.
template <class F> void time_it(const char *peer, const ModelFile &m, const char *quantity, Loops loops, F f) {
  f();
  double start = cpu_seconds();
  f();
  long calls = std::max(1L, (long)(loops.seconds / std::max(cpu_seconds() - start, 1e-8)));
  start = cpu_seconds();
  for (long k = 0; k < calls; k++) f();
  double each = (cpu_seconds() - start) / calls; // caches are warm now: a better guess
  calls = std::max(1L, (long)(loops.seconds / each));
  int count = each > 0.1 ? std::min(loops.count, 5) : loops.count;
  std::vector<double> times;
  for (int i = 0; i < count; i++) {
    start = cpu_seconds();
    for (long k = 0; k < calls; k++) f();
    times.push_back((cpu_seconds() - start) / calls * 1e9);
  }
  std::sort(times.begin(), times.end());
  printf("%s,%s,%s,%.6g,%.6g\n", peer, m.name.c_str(), quantity, times[0], times[times.size() / 2]);
  fflush(stdout);
}

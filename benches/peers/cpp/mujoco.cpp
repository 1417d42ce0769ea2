// MuJoCo's forward dynamics, timed and checked.
//   mujoco MODEL LOOPS SECONDS          prints peer,model,quantity,min,median in nanoseconds of CPU time
//   mujoco MODEL --check ACCELERATIONS  the relative distance to the accelerations of another program
#include "mujoco.hpp"

// The shortest public sequence that gives the accelerations of the smooth dynamics.
static void smooth(const mjModel *m, mjData *d) {
  mj_kinematics(m, d);
  mj_comPos(m, d);
  mj_makeM(m, d);
  mj_factorM(m, d);
  mj_comVel(m, d);
  mj_rne(m, d, 0, d->qfrc_bias);
  for (int i = 0; i < m->nv; i++) d->qfrc_smooth[i] = d->qfrc_applied[i] - d->qfrc_bias[i];
  mj_solveM(m, d, d->qacc_smooth, d->qfrc_smooth, 1);
}

int main(int argc, char **argv) {
  if (argc != 4) {
    fprintf(stderr, "mujoco MODEL LOOPS SECONDS | MODEL --check ACCELERATIONS\n");
    return 2;
  }
  ModelFile file = read_model(argv[1]);
  MuJoCo mj(file);
  mj.start(file);
  if (!strcmp(argv[2], "--check")) {
    std::vector<double> theirs = read_numbers(argv[3]);
    smooth(mj.m, mj.d);
    printf("%.3e\n", distance(theirs, mj.in_order(file, mj.d->qacc_smooth)) / norm(theirs));
    return 0;
  }
  Loops loops = {atoi(argv[2]), atof(argv[3])};
  time_it("mujoco", file, "smooth", loops, [&] { smooth(mj.m, mj.d); });
  time_it("mujoco", file, "forward", loops, [&] { mj_forward(mj.m, mj.d); });
}

/* The same in C, built with what pkg-config says. */
#include <stdio.h>

#include <vcd/runtime/vcd.h>

int main(int argc, char** argv) {
  const vcd_sidecar* sidecar = NULL;
  vcd_error error = {sizeof error, ""};
  if (vcd_open(argc > 1 ? argv[1] : "", NULL, &sidecar, &error) != VCD_SUCCESS)
    return fprintf(stderr, "%s\n", error.message), 1;
  const vcd_segment far_away = {{20, 20, 20}, 0, {1, 0, 0}, 1};
  printf("%zu objects, %d\n", vcd_object_count(sidecar), vcd_classify(vcd_object_at(sidecar, 0), &far_away));
  vcd_close(sidecar);
  return 0;
}

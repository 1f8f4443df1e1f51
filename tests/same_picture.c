/* same_picture A B: exit status 0 where two pictures of one size look the same: in codes of full
 * scale 1, a mean difference of at most 0.01 and at most 1 % of the samples off by over 0.15. It
 * forgives JPEG and a last digit of a caption, and nothing that has moved. */
#include <halflight/halflight.h>
#include <math.h>
#include <stdio.h>

int main(int argc, char **argv)
{
  hl_ctx ctx = {0};
  hl_frame frame[2] = {{0}};
  hl_frame_settings as_is = hl_frame_defaults();
  as_is.transfer = HL_TRANSFER_LINEAR;
  if (argc != 3) {
    fputs("usage: same_picture A B\n", stderr);
    return 2;
  }
  for (int i = 0; i < 2; i++)
    if (hl_frame_read(&ctx, argv[1 + i], &as_is, &frame[i]) != HL_OK) {
      fprintf(stderr, "same_picture: %s\n", ctx.msg);
      return 2;
    }
  if (frame[0].width != frame[1].width || frame[0].height != frame[1].height ||
      frame[0].channels != frame[1].channels) {
    printf("%d x %d x %d and %d x %d x %d\n", frame[0].width, frame[0].height, frame[0].channels,
           frame[1].width, frame[1].height, frame[1].channels);
    return 1;
  }
  const long n = (long)frame[0].width * frame[0].height * frame[0].channels;
  double sum = 0;
  long off = 0;
  for (long i = 0; i < n; i++) {
    const double difference = fabs((double)frame[0].radiance[i] - (double)frame[1].radiance[i]);
    sum += difference;
    off += difference > 0.15;
  }
  hl_frame_free(&frame[0]);
  hl_frame_free(&frame[1]);
  const double mean = sum / (double)n, share = (double)off / (double)n;
  printf("mean difference %.5f, %.3f %% off\n", mean, 100 * share);
  return mean <= 0.01 && share <= 0.01 ? 0 : 1;
}

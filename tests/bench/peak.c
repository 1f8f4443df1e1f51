/* peak COMMAND [argument ...]: runs it and prints its peak resident size in MB (10^6 bytes) on
 * stderr's last line; its exit status is the command's. */
#include <stdio.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

int main(int argc, char **argv)
{
  if (argc < 2) {
    fputs("usage: peak COMMAND [argument ...]\n", stderr);
    return 2;
  }
  const pid_t child = fork();
  if (child == 0) {
    execvp(argv[1], argv + 1);
    perror(argv[1]);
    _exit(127);
  }
  int status = 0;
  struct rusage usage;
  if (child < 0 || waitpid(child, &status, 0) != child || getrusage(RUSAGE_CHILDREN, &usage) != 0) {
    perror("peak");
    return 1;
  }
  fprintf(stderr, "%.1f\n", (double)usage.ru_maxrss * 1024 / 1e6); /* Linux counts in KiB */
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

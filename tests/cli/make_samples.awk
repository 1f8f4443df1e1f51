# awk -v n=N [-v light=x,y,z] [-v gloss=G] [-v body=K] [-v power=P] -f make_samples.awk: SAMPLES.csv of normals on a
# spiral, K n.s + G (n.h)^P under a light (default 1,1,1), view (0,0,1), three channels.
BEGIN {
  if (gloss == "") gloss = 1
  if (body == "") body = 1
  if (power == "") power = 20
  split(light == "" ? "1,1,1" : light, s, ",")
  l = sqrt(s[1] * s[1] + s[2] * s[2] + s[3] * s[3])
  for (k = 1; k <= 3; k++) s[k] /= l
  half = sqrt(2 + 2 * s[3])
  print "nx,ny,nz,r,g,b"
  for (i = 0; i < n; i++) {
    z = 1 - 0.95 * (i + 0.5) / n
    r = sqrt(1 - z * z)
    t = 10.166407384630519 * (i + 0.5)
    x = r * cos(t)
    y = r * sin(t)
    ns = s[1] * x + s[2] * y + s[3] * z
    if (ns < 0.02) continue
    nh = (ns + z) / half
    g = gloss * exp(power * log(nh > 1e-9 ? nh : 1e-9))
    printf "%.12f,%.12f,%.12f,%.12f,%.12f,%.12f\n", x, y, z, body * ns + g, 0.5 * body * ns + g, 0.2 * body * ns + g
  }
}

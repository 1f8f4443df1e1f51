# Angle between the first "direction" of a light.json and make_ball's light; fails above limit [deg].
#   awk -v light=x,y,z -v limit=D -f near_truth.awk light.json
BEGIN { split(light, t, ",") }
/"direction":/ && !found {
  gsub(/.*\[|\].*/, "")
  split($0, d, ",")
  found = 1
}
END {
  for (i = 1; i <= 3; i++) {
    dt += d[i] * t[i]
    dd += d[i] * d[i]
    tt += t[i] * t[i]
  }
  cross = dd * tt - dt * dt
  angle = atan2(sqrt(cross > 0 ? cross : 0), dt) * 57.29577951308232
  printf "%.4f deg off\n", angle
  exit !(found && angle <= limit)
}

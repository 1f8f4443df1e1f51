# What the cases of position read: left and right, two balls 0.6 m apart that show a light.

# position_pair NAME X TOWARDS_X: a ball at (X, 0, 0.6) m that shows a near light along (TOWARDS_X, 0, -1)
position_pair()
{
  awk -v x="$2" -v a="$3" -v name="$1" 'BEGIN {
    l = sqrt(a * a + 1)
    printf "{\"format\": \"halflight-light\", \"version\": 1, \"lights\": [{\"direction\": [%.15g, 0, %.15g],\n" \
      " \"tangent_basis\": [[0, 1, 0], [%.15g, 0, %.15g]], \"covariance_rad2\": [[1e-6, 0], [0, 1e-6]],\n" \
      " \"position_m\": [0, 0, 0]}]}\n", a / l, -1 / l, 1 / l, a / l > (name "-light.json")
    printf "{\"format\": \"halflight-sphere\", \"version\": 1, \"center_m\": [%g, 0, 0.6], \"radius_m\": 0.02}\n", \
      x > (name ".json")
  }'
}

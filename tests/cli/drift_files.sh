# Cameras and boards for the cases of `drift`; sourced by their setup.

# drift_camera FILE FX WIDTH COVARIANCE: a pinhole without distortion; COVARIANCE is good, singular or none
drift_camera()
{
  awk -v fx="$2" -v width="$3" -v kind="$4" 'BEGIN {
    printf "{\"format\":\"halflight-camera\",\"version\":1,\"model\":\"pinhole\",\"width\":%d,\"height\":480,", width
    printf "\"fx\":%s,\"fy\":%s,\"cx\":319.5,\"cy\":239.5,\"distortion\":[0,0,0,0,0],", fx, fx
    if (kind != "none") {
      split("0.01 0.01 0.01 0.01 1e-6 1e-6 1e-8 1e-8 1e-6", variance, " ")
      printf "\"covariance\":["
      for (i = 1; i <= 9; i++) {
        printf "%s[", (i > 1 ? "," : "")
        for (k = 1; k <= 9; k++)
          printf "%s%s", (k > 1 ? "," : ""), (i != k || (kind == "singular" && i == 4) ? 0 : variance[i])
        printf "]"
      }
      printf "],"
    }
    print "\"rms_px\":0.2,\"observations\":2000}"
  }' >"$1"
}

# drift_corners FILE FX X_M COPIES: a chessboard of 9 x 7 corners seen straight on from 0.5 m
drift_corners()
{
  awk -v fx="$2" -v x="$3" -v copies="$4" 'BEGIN {
    for (copy = 1; copy <= copies; copy++)
      for (row = 0; row < 7; row++)
        for (column = 0; column < 9; column++)
          printf "fixed%d.png %.9f %.9f\n", copy, fx * (x + 0.03 * column) / 0.5 + 319.5,
            fx * (-0.09 + 0.03 * row) / 0.5 + 239.5
  }' >"$1"
}

# drift_pose FILE SPEC: where that board is
drift_pose()
{
  printf '{"format":"halflight-board-pose","version":1,"target":"%s","cam_from_board":[0,0,0,-0.12,-0.09,0.5]}\n' \
    "$2" >"$1"
}

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

# drift_rig FILE TURN_RAD FACTOR: lights.json of eight lights, the third turned by TURN_RAD, the sixth FACTOR as bright
drift_rig()
{
  drift_camera "$1.camera" 700 640 good
  awk -v turn="$2" -v factor="$3" -v camera="$(cat "$1.camera")" 'BEGIN {
    zeros = "[0,0,0,0,0,0,0,0,0]"
    printf "{\"format\":\"halflight-lights\",\"version\":1,\"trusted\":true,\"reasons\":[],\"camera\":%s,", camera
    printf "\"balls\":[{\"format\":\"halflight-sphere\",\"version\":1,\"center_m\":[0,0,0.5],\"radius_m\":0.025,"
    printf "\"covariance\":[[1e-10,0,0],[0,1e-10,0],[0,0,1e-8]]}],\"lights\":["
    for (i = 0; i < 8; i++) {
      a = 0.785398 * i
      e = 0.5 + 0.3 * (i % 2) + (i == 2 ? turn : 0) # from the horizon; the tangents point along it and up
      printf "%s{\"frame\":%d,\"file\":\"%d.png\",\"label\":\"L%d\",\"ball\":0,\"found\":true,\"trusted\":true,", (i ? "," : ""), i, i, i
      printf "\"reasons\":[],\"exposure_us\":1000,\"gain\":1,"
      printf "\"direction\":[%.12f,%.12f,%.12f],", cos(e) * cos(a), cos(e) * sin(a), -sin(e)
      printf "\"tangent_basis\":[[%.12f,%.12f,0],[%.12f,%.12f,%.12f]],", -sin(a), cos(a), -sin(e) * cos(a), -sin(e) * sin(a), -cos(e)
      printf "\"covariance_rad2\":[[1e-7,0],[0,1e-7]],\"own_rad2\":[[1e-7,0],[0,1e-7]],\"ellipse_95_rad\":[0.00077,0.00077],"
      printf "\"by_center\":[[0,0,0],[0,0,0]],\"by_intrinsics\":[%s,%s],\"color\":[1,1,1],", zeros, zeros
      v = i == 5 ? factor : 1
      printf "\"intensity\":[%g,%g,%g],\"intensity_sigma\":0.005,\"position_m\":null}", v, v, v
    }
    print "],\"used\":[],\"left_out\":[]}"
  }' >"$1"
  rm "$1.camera"
}

/PROG  KR_270_MI_F2O4SI
/ATTR
OWNER		= MNEDITOR;
COMMENT		= "elastocal";
PROG_SIZE	= 0;
CREATE		= DATE 00-01-01  TIME 00:00:00;
MODIFIED	= DATE 00-01-01  TIME 00:00:00;
FILE_NAME	= ;
VERSION		= 0;
LINE_COUNT	= 116;
MEMORY_SIZE	= 0;
PROTECT		= READ_WRITE;
TCD:  STACK_SIZE	= 0,
      TASK_PRIORITY	= 50,
      TIME_SLICE	= 0,
      BUSY_LAMP_OFF	= 0,
      ABORT_REQUEST	= 0,
      PAUSE_REQUEST	= 0;
DEFAULT_GROUP	= 1,*,*,*,*;
CONTROL_CODE	= 00000000 00000000;
/MN
   1:  !Calibration campaign: 4 ;
   2:  !experiments in 3 configurations. ;
   3:  !Made by elastocal 0.1.0 from KR ;
   4:  !270 milling cell. ;
   5:  !plan sha256 0123456789abcdef ;
   6:  !Start: load all of ;
   7:  !KR_270_MI_F2O4SI, select ;
   8:  !KR_270_MI_F2O4SI, run it in T1 ;
   9:  !first. ;
  10:  !Robot: kuka-kr270. Joint values: ;
  11:  !deg, mm, as in the model. ;
  12:  !Forces act at the load point of ;
  13:  !the tool, in the axes of the ;
  14:  !robot base. ;
  15:  !No home position: the first ;
  16:  !motion starts where the robot ;
  17:  !stands. ;
  18:  !Watched for collisions: floor, ;
  19:  !the robot against itself. ;
  20:  !SAFETY: check this program at ;
  21:  !low speed in manual mode first. ;
  22:  !Motions from point to point were ;
  23:  !checked for collisions with what ;
  24:  !the study names, in this order ;
  25:  !and from home, the way to home ;
  26:  !was not. ;
  27:  !Set the payload of the empty ;
  28:  !calibration tool and leave it ;
  29:  !so, loaded and unloaded: the ;
  30:  !controller must not compensate ;
  31:  !what is to be measured. ;
  32:  !elastocal program 000000000000 ;
  33:  UFRAME_NUM=0 ;
  34:  UTOOL_NUM=1 ;
  35:  !to AP1 ;
  36:J P[1] 10% FINE    ;
  37:  !to P1 ;
  38:J P[2] 10% FINE    ;
  39:  WAIT   2.00(sec) ;
  40:  MESSAGE[Experiment 1/4: pose 1.] ;
  41:  MESSAGE[NO load. Measure M1.] ;
  42:  PAUSE ;
  43:  MESSAGE[Experiment 1/4: hang] ;
  44:  MESSAGE[254.929 kg, Fx 0 Fy 0 Fz] ;
  45:  MESSAGE[-2500 N.] ;
  46:  PAUSE ;
  47:  WAIT   2.00(sec) ;
  48:  MESSAGE[Experiment 1/4: pose 1.] ;
  49:  MESSAGE[LOADED. Measure M1.] ;
  50:  PAUSE ;
  51:  MESSAGE[Experiment 1/4: take the] ;
  52:  MESSAGE[load off. The robot] ;
  53:  MESSAGE[moves next.] ;
  54:  PAUSE ;
  55:  !to AP1 ;
  56:J P[1] 10% FINE    ;
  57:  !to P1 ;
  58:J P[2] 10% FINE    ;
  59:  WAIT   2.00(sec) ;
  60:  MESSAGE[Experiment 2/4: pose 1.] ;
  61:  MESSAGE[NO load. Measure M1.] ;
  62:  PAUSE ;
  63:  MESSAGE[Experiment 2/4: hang] ;
  64:  MESSAGE[254.929 kg, Fx 0 Fy 0 Fz] ;
  65:  MESSAGE[-2500 N.] ;
  66:  PAUSE ;
  67:  WAIT   2.00(sec) ;
  68:  MESSAGE[Experiment 2/4: pose 1.] ;
  69:  MESSAGE[LOADED. Measure M1.] ;
  70:  PAUSE ;
  71:  MESSAGE[Experiment 2/4: take the] ;
  72:  MESSAGE[load off. The robot] ;
  73:  MESSAGE[moves next.] ;
  74:  PAUSE ;
  75:  !to AP2 ;
  76:J P[3] 10% FINE    ;
  77:  !to P2 ;
  78:J P[4] 10% FINE    ;
  79:  WAIT   2.00(sec) ;
  80:  MESSAGE[Experiment 3/4: pose 2.] ;
  81:  MESSAGE[NO load. Measure M1.] ;
  82:  PAUSE ;
  83:  MESSAGE[Experiment 3/4: hang] ;
  84:  MESSAGE[254.929 kg, Fx 0 Fy 0 Fz] ;
  85:  MESSAGE[-2500 N.] ;
  86:  PAUSE ;
  87:  WAIT   2.00(sec) ;
  88:  MESSAGE[Experiment 3/4: pose 2.] ;
  89:  MESSAGE[LOADED. Measure M1.] ;
  90:  PAUSE ;
  91:  MESSAGE[Experiment 3/4: take the] ;
  92:  MESSAGE[load off. The robot] ;
  93:  MESSAGE[moves next.] ;
  94:  PAUSE ;
  95:  !to AP3 ;
  96:J P[5] 10% FINE    ;
  97:  !to P3 ;
  98:J P[6] 10% FINE    ;
  99:  WAIT   2.00(sec) ;
 100:  MESSAGE[Experiment 4/4: pose 3.] ;
 101:  MESSAGE[NO load. Measure M1.] ;
 102:  PAUSE ;
 103:  MESSAGE[Experiment 4/4: hang] ;
 104:  MESSAGE[254.929 kg, Fx 0 Fy 0 Fz] ;
 105:  MESSAGE[-2500 N.] ;
 106:  PAUSE ;
 107:  WAIT   2.00(sec) ;
 108:  MESSAGE[Experiment 4/4: pose 3.] ;
 109:  MESSAGE[LOADED. Measure M1.] ;
 110:  PAUSE ;
 111:  MESSAGE[Experiment 4/4: take the] ;
 112:  MESSAGE[load off. The robot] ;
 113:  MESSAGE[moves next.] ;
 114:  PAUSE ;
 115:  !to AP3 ;
 116:J P[5] 10% FINE    ;
/POS
P[1]{
   GP1:
	UF : 0, UT : 1,	
	J1=   -0.5000 deg,	J2=  -51.2922 deg,	J3=   62.5588 deg,
	J4=  -32.0611 deg,	J5=  101.1598 deg,	J6=  -94.2903 deg
};
P[2]{
   GP1:
	UF : 0, UT : 1,	
	J1=    0.0000 deg,	J2=  -50.7922 deg,	J3=   63.0588 deg,
	J4=  -32.5611 deg,	J5=  101.6598 deg,	J6=  -93.7903 deg
};
P[3]{
   GP1:
	UF : 0, UT : 1,	
	J1=   -0.5000 deg,	J2=  -55.9571 deg,	J3=  -72.9034 deg,
	J4= -118.8938 deg,	J5=  -57.0916 deg,	J6= -179.7668 deg
};
P[4]{
   GP1:
	UF : 0, UT : 1,	
	J1=    0.0000 deg,	J2=  -55.4571 deg,	J3=  -72.4034 deg,
	J4= -119.3938 deg,	J5=  -56.5916 deg,	J6= -179.2668 deg
};
P[5]{
   GP1:
	UF : 0, UT : 1,	
	J1=   -0.5000 deg,	J2=   -2.1852 deg,	J3=   -4.2994 deg,
	J4=  -57.7496 deg,	J5=   39.0358 deg,	J6=  168.3163 deg
};
P[6]{
   GP1:
	UF : 0, UT : 1,	
	J1=    0.0000 deg,	J2=   -1.6852 deg,	J3=   -3.7994 deg,
	J4=  -58.2496 deg,	J5=   39.5358 deg,	J6=  168.8163 deg
};
/END
